// Checks of a finished run: energy balance, penetration, energy gained in impacts, finite values.
// Each check adds a note to the Result or replaces its ending by a failure. The bounds are in
// assess.cpp.
#pragma once

#include <optional>
#include <string_view>

#include "facade/simulation.hpp"
#include "values/family.hpp"
#include "values/result.hpp"

namespace freeplay {

class System;

/// Adds notes about doubtful results: penetration beyond the bound of the formulation, contacts
/// that add energy, an energy balance that does not close. `finer` is the key whose smaller value
/// refines the steps of the run (fineness_key()). Energies are compared with the greatest energy
/// that occurred during the run, because a motion may have dissipated most of it at the end. Energies
/// below `rounding` (J) are not judged. The works of drives and loads are integrals without error
/// control: where these reverse many times, the balance may be off by 1e-6 of the work exchanged.
void warn(Result& result, Family family, std::string_view finer, double rounding = 0);

/// Energy (J) that rounding of velocities exchanges with the forces f at the start within `time` (s),
///
///     256 ε Σ |f_c| V time,    V = √(ℓ max |f_c|/m_c),
///
/// with the longest arm ℓ, and f and m of an angle divided by ℓ and ℓ². In a mechanism at rest all terms of
/// the balance are of this size.
double rounding_energy(const System& system, const State& start, double time);

/// Fails a finished run of an impact law in which a penetration exceeded the contact's measure, a
/// clearance or a radius. Beyond this bound the journal is outside its bearing and the computed
/// motion belongs to another mechanism. Penalty contacts are compliant; warn() reports their
/// penetration.
void refuse_too_deep(Result& result, Family family, std::string_view finer);

/// Fails a run whose final state or energies are not finite, whatever the cause.
void refuse_not_finite(Result& result);

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
