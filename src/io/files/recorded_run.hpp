// Reading of a recorded run, from its identity or its run.json: everything needed to repeat or
// continue it (`freeplay run --from`, `--resume`).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "io/files/identity.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {

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
