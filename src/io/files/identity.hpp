// Text of an identity (values/identity.hpp): writes its parts. recorded_run.hpp reads them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mechanism/outside.hpp"
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

}  // namespace freeplay
