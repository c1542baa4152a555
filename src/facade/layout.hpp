// The Layout of a simulation: names and sizes of its parts.
#pragma once

#include "simulation/observer.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Scene;
class System;

/// The layout of a scene's system that starts at this state.
Layout layout_of(const Scene& scene, const System& system, const State& start);

}  // namespace freeplay
