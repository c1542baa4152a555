#pragma once

#include <memory>
#include <vector>

#include "simulation/formulation.hpp"

namespace freeplay {

struct Scene;
class System;

/// The nonsmooth formulation of a scene, started at `state`. `restitution`, when not empty, replaces what the
/// surfaces ask for, one value per contact. Throws ModelError when a surface has no restitution.
std::unique_ptr<Formulation> make_nonsmooth(const Scene& scene, const System& system, const State& state,
                                            const std::vector<double>& restitution);

}  // namespace freeplay
