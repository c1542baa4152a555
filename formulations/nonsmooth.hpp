// Factory of the nonsmooth formulation: impact laws and set-valued friction, by time stepping, the
// event-driven scheme, or the automatic scheme.
#pragma once

#include <memory>
#include <vector>

#include "simulation/formulation.hpp"

namespace freeplay {

struct Scene;
class System;

/// Makes the nonsmooth formulation of a scene, started at `state`. `restitution`, if not empty,
/// replaces the surfaces' coefficients of restitution, one value per contact. Throws ModelError if
/// a surface has no coefficient of restitution.
std::unique_ptr<Formulation> make_nonsmooth(const Scene& scene, const System& system, const State& state,
                                            const std::vector<double>& restitution);

}  // namespace freeplay
