// Reads the mechanism of a scene from its sections.
#pragma once

#include "io/scene/section.hpp"

namespace freeplay {

struct Mechanism;

/// Reads the keys of a scene that describe the mechanism, and checks each value. Throws SceneError.
Mechanism read_mechanism(Section& root);

}  // namespace freeplay
