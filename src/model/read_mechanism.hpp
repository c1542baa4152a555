#pragma once

#include "model/section.hpp"

namespace freeplay {

/// Reads the keys of a scene that describe the mechanism and checks each fact. Throws SceneError.
Mechanism read_mechanism(Section& root);

/// Index of the body called `name`, `ground` for the ground; fails at `key` for any other.
int body_index(const Mechanism& mechanism, const Section& section, std::string_view key,
               const std::string& name);

}  // namespace freeplay
