// Text of an identity (values/identity.hpp): writes its parts. identity.hpp reads them.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mechanism/outside.hpp"
#include "mechanism/scene.hpp"
#include "values/identity.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Scene;

/// Identity::program of this program on this machine.
std::string program_identity();

/// Short form for messages: the version and the first digits of the program identity's hash.
std::string program_name(const std::string& identity);

/// Identity::formulation. `restitution`: coefficients taken from the penalty law, one for each
/// contact, if `matched`; else empty.
std::string formulation_identity(std::string_view formulation, bool matched,
                                 const std::vector<double>& restitution);

/// Additional lines of Identity::formulation for outside code; empty without such code.
std::string outside_identity(const Outside& outside);

/// Identity::given of a run whose start the caller sets.
std::string start_identity(const std::optional<State>& start);

/// Origin of a scene, for users and for positions in messages. It is not part of the identity.
struct Origin {
  std::string file, text;
  std::vector<std::string> overrides;
  bool states_format = false;

  template <class M>
  void serialize(M& m) {
    m(file, text, overrides, states_format);
  }
};
/// The origin of a scene, from the file it was read from.
Origin origin_of(const Scene& scene);

// Reading of a recorded run, from its identity or its run.json: everything needed to repeat or
// continue it (`freeplay run --from`, `--resume`).

/// A scene and the parameters of its run, as an identity states them.
struct Setup {
  Scene scene;
  std::string formulation;
  bool matched = false;
  std::optional<State> start;
  /// Outside code that the run used, by its purpose ("normal forces").
  struct FromOutside {
    std::string name, digest;
  };
  std::map<std::string, FromOutside> outside;

  /// Adds outside code to the scene. Throws SceneError if it differs from that of the run, or is
  /// missing.
  void give(const Outside& given);
};

/// Reads the setup of a run. Facts and parameters come from the identity alone; file name, text and
/// overrides come from `origin`. Throws SceneError if the identity is not that of a single run.
Setup setup_of(const Identity& identity, const Origin& origin);

/// A run as recorded in its run.json.
struct RecordedRun {
  Identity identity;
  Setup setup;  ///< its scene has the run's file, text and overrides, for the provenance
};

/// Reads a run.json. Throws SceneError if the file is damaged, not a run.json, or of a version
/// without identities.
RecordedRun read_run(const std::filesystem::path& file);

}  // namespace freeplay
