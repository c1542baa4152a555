// Factory of the nonsmooth formulation: impact laws and set-valued friction, by time stepping, the
// event-driven scheme, or the automatic scheme.
#pragma once

#include <memory>
#include <vector>

#include "simulation/formulation.hpp"

namespace freeplay {

struct Scene;
struct RowFacts;
class AdaptiveMoreau;
class AutomaticStepper;
class EventDriven;
class System;

/// Makes the nonsmooth formulation of a scene, started at `state`. `restitution`, if not empty,
/// replaces the surfaces' coefficients of restitution, one value per contact. Throws ModelError if
/// a surface has no coefficient of restitution.
std::unique_ptr<Formulation> make_nonsmooth(const Scene& scene, const System& system, const State& state,
                                            const std::vector<double>& restitution);

/// Makes the event-driven scheme of a scene, with one coefficient of restitution per contact.
EventDriven make_event_driven(const Scene& scene, const System& system,
                              const std::vector<double>& restitution, RowFacts facts, const State& state);

/// Likewise adaptive time stepping.
AdaptiveMoreau make_adaptive(const Scene& scene, const System& system, const std::vector<double>& restitution,
                             RowFacts facts, const State& state);

/// Likewise the automatic scheme, for impact laws that time stepping has.
AutomaticStepper make_automatic(const Scene& scene, const System& system,
                                const std::vector<double>& restitution, RowFacts facts, const State& state);

}  // namespace freeplay
