// Factory of formulations: selects the formulation that a scene asks for and builds it. No other
// file depends on all of them.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/assembly/compliance.hpp"
#include "simulation/formulation.hpp"
#include "values/family.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Scene;
class System;

/// Makes a formulation of a scene, started at `state`. The scene and the system must outlive it.
/// `restitution`, if not empty, has one value per contact, which the impact law uses in place of
/// the surfaces' values. Throws ModelError if the scene lacks data that the formulation needs.
std::unique_ptr<Formulation> make(Family family, const Scene& scene, const System& system, const State& state,
                                  const std::vector<double>& restitution = {});

/// The coefficient of restitution that each contact delivers in a free impact under the scene's
/// penalty law.
std::vector<double> delivered_restitutions(const Scene& scene, const System& system);

/// The static compliance of each contact under a formulation; empty if contacts are rigid. Throws
/// ModelError like make().
Compliances compliances(Family family, const Scene& scene, const System& system);

}  // namespace freeplay
