// Error estimate for the first contacts of a time-stepped run, by step refinement.
//
// Time stepping applies the impulse of a contact within the step of its onset, so the onset, and
// everything after it, has an error C h. C depends on the position of the onset in the step
// (docs/development/decisions/006). For two runs with the steps h and h/r
//
//     |C h| ≤ |difference| + |C' h/r|,   |C'| ≈ |C|   ⇒   error(h) ≲ r/(r − 1) |difference|.
//
// C and C' agree on average only, so the estimate is twice this bound.
//
// doubt_first_touches() repeats the beginning of the run at the step h and at h/r, r = 2 … 8, and
// compares the first contact onsets. add_companion() calls it after a finished run and writes the
// estimate and a note into the Result. The functions keep no state.
#pragma once

#include <optional>

#include "facade/simulation.hpp"

namespace freeplay {

struct Scene;

/// Number of first contact onsets that are compared.
inline constexpr int companion_touches = 3;
/// Estimated relative error above which the note about the first contact onsets is a warning.
inline constexpr double doubtful_touches = 0.05;

/// Estimates the error of the first contact onsets. Returns nullopt for a scheme that locates its
/// events or chooses its steps, for a run without contact onsets, and after a stop request. Costs
/// as many steps as the run takes to its first onsets and at least twice as many again, usually a
/// few per cent of a run. It does not change the run.
std::optional<OnsetDoubt> doubt_first_touches(const Scene& scene, const SimulationOptions& options,
                                              const StopToken& stop);

/// Adds the estimate and its note to a result.
void add(const OnsetDoubt& doubt, Result& result);

/// Estimates and adds, for a finished run of the nonsmooth formulation; does nothing for other
/// runs.
void add_companion(const Simulation& simulation, const SimulationOptions& options, const StopToken& stop,
                   Result& result);

}  // namespace freeplay
