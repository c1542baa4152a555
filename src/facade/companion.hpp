// How far the first touches of a time-stepped run may be off, measured: the same run once more at a shorter step.
//
// A touch acts somewhere within its step, so its time, and with it all that follows, has an error C h, where C depends
// on where in the step (docs/development/decisions/006). Of two runs at h and h/r
//
//     |C h| ≤ |difference| + |C' h/r|,   |C'| ≈ |C|   ⇒   error(h) ≈ r/(r − 1) difference at most,
//
// and twice that is said: C and C' are alike on average only.
#pragma once

#include <optional>

#include "facade/simulation.hpp"

namespace freeplay {

struct Scene;

/// Touches that a companion looks at.
inline constexpr int companion_touches = 3;
/// Beyond this share a run's first touches are doubtful.
inline constexpr double doubtful_touches = 0.05;

/// Nothing for a scheme that locates its events or chooses its steps, without touches, or when asked to stop. Costs as
/// many steps as the run takes to its first touches and at least twice as many more, as a rule some per cent of a run; the
/// run itself is not touched.
std::optional<TouchDoubt> doubt_first_touches(const Scene& scene, const SimulationOptions& options,
                                              const StopToken& stop);

/// Adds it to a result, with its note.
void add(const TouchDoubt& doubt, Result& result);

/// Both, of a time-stepped run that has finished; of any other nothing.
void add_companion(const Simulation& simulation, const SimulationOptions& options, const StopToken& stop,
                   Result& result);

}  // namespace freeplay
