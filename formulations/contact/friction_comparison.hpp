// Friction laws at the same regularisation speed, for comparison. The keys friction_v0 and
// friction_v1 have another meaning in each law, so that equal keys do not give equally steep laws.
// Here the regularisation speed v_r is the sliding speed at which a law first reaches 95 % of the
// kinetic friction,
//
//     c(v_r) = 0.95 μ,
//
// the value of Threlfall's law at its v₀. Laws that stick by a spring have no such speed.
#pragma once

#include <optional>

#include "mechanism/laws.hpp"

namespace freeplay {

struct PenaltyOptions;

/// Share of the kinetic friction at the regularisation speed.
inline constexpr double regularised_share = 0.95;

/// The options with the speed keys of a law that has the regularisation speed v_r (m/s): friction_v1
/// with friction_v0 = 0 for Ambrósio's law, else friction_v0. Empty for laws that stick, and if the
/// law does not reach that friction (μ_s > μ does not matter).
std::optional<PenaltyOptions> regularised(const FrictionLawFacts& law, const PenaltyOptions& options,
                                          double speed);

/// The regularisation speed (m/s) of a law with these options; empty as above.
std::optional<double> regularisation_speed(const FrictionLawFacts& law, const PenaltyOptions& options);

/// The least speed (m/s) at which a law resists `share` of the kinetic friction in steady sliding: a
/// contact under such a load creeps at it.
double creep_speed(const FrictionLawFacts& law, const PenaltyOptions& options, double share);

}  // namespace freeplay
