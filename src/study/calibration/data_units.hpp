// Whether a measured acceleration is in the unit that it should be in, asked of the motion that play hardly changes: the
// lowest harmonics of the turn follow the crank.
#pragma once

#include <string>

#include "measure/turns.hpp"

namespace freeplay {

/// The question to ask when the first three harmonics of a measurement (m/s²) are those of the ideal mechanism in
/// another unit, g, cm/s² or mm/s², to a third; else empty.
std::string unit_question(const TurnMetrics& measured, const TurnMetrics& ideal);

}  // namespace freeplay
