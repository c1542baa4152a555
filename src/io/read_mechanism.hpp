#pragma once

#include "io/section.hpp"

namespace freeplay {

/// Reads the keys of a scene that describe the mechanism and checks each fact. Throws SceneError.
Mechanism read_mechanism(Section& root);

/// Index of the body called `name`, `ground` for the ground; fails at `key` for any other.
int body_index(const Mechanism& mechanism, const Section& section, std::string_view key,
               const std::string& name);

/// The key `axis` as a unit vector, bit for bit if it is one; (1, 0) if it is left out.
Vec2 read_axis(Section& section);

}  // namespace freeplay
