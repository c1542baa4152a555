// The parts of an identity as text, and back.
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

/// One line for people: version and the beginning of the hash over a program's identity.
std::string program_name(const std::string& identity);

/// `restitution`: of each contact, where the penalty law's were taken; else empty and not `matched`.
std::string formulation_identity(std::string_view formulation, bool matched,
                                 const std::vector<double>& restitution);

/// Further lines of a formulation's with code from outside; empty without.
std::string outside_identity(const Outside& outside);

/// Identity::given of a run that starts where its caller says.
std::string start_identity(const std::optional<State>& start);

/// Where a scene came from: for people, and for the places in messages. No part of an identity.
struct Origin {
  std::string file, text;
  std::vector<std::string> overrides;
  bool states_format = false;

  template <class M>
  void remember(M& m) {
    m(file, text, overrides, states_format);
  }
};
Origin origin_of(const Scene& scene);

}  // namespace freeplay
