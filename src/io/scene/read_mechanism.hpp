#pragma once

#include "io/scene/section.hpp"

namespace freeplay {

struct Mechanism;

/// Reads the keys of a scene that describe the mechanism and checks each fact. Throws SceneError.
Mechanism read_mechanism(Section& root);

}  // namespace freeplay
