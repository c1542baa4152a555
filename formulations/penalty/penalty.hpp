#pragma once

#include <memory>

#include "model/scene.hpp"
#include "sim/formulation.hpp"

namespace freeplay {

/// The penalty formulation of a scene, started at `state`. Throws SceneError when a surface lacks what a
/// contact force needs.
std::unique_ptr<Formulation> make_penalty(const Scene& scene, const System& system, const State& state);

/// The restitution that the scene's contact law delivers in a free impact when asked for `restitution`.
double delivered_by(const PenaltyOptions& options, double restitution);

}  // namespace freeplay
