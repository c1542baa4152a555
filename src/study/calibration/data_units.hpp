// Check of the unit of a measured acceleration. The lowest harmonics of a turn follow the crank and
// depend little on the clearance, so they are compared with those of the ideal mechanism.
#pragma once

#include <string>

#include "measure/turns.hpp"

namespace freeplay {

/// Question to the user if the first three harmonics of a measurement (m/s²) agree within a third
/// with those of the ideal mechanism in another unit, g, cm/s² or mm/s²; else empty.
std::string unit_plausibility(const TurnMetrics& measured, const TurnMetrics& ideal);

}  // namespace freeplay
