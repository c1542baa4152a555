// The one place that knows every formulation.
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

/// Makes a formulation of a scene, started at `state`; scene and system must outlive it. `restitution`, when
/// not empty, is what an impact law shall take in place of the surfaces' values, one per contact. Throws
/// ModelError when the scene lacks what the formulation needs.
std::unique_ptr<Formulation> make(Family family, const Scene& scene, const System& system, const State& state,
                                  const std::vector<double>& restitution = {});

/// The restitution that each contact delivers in a free impact under the scene's penalty law.
std::vector<double> delivered_restitutions(const Scene& scene, const System& system);

/// How contacts yield to a lasting load under a formulation; empty: they do not. Throws ModelError as make().
Compliances compliances(Family family, const Scene& scene, const System& system);

}  // namespace freeplay
