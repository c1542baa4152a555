// Checks of a finished run: energy balance, penetration, energy gained in impacts, finite values.
// Each check adds a note to the Result or replaces its ending by a failure. The bounds are in
// assess.cpp.
#pragma once

#include <string_view>

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

}  // namespace freeplay
