// What a finished run is told about itself.
#pragma once

#include <string_view>

#include "values/family.hpp"
#include "values/result.hpp"

namespace freeplay {

/// Adds notes on what makes a result doubtful: a journal deep in its wall, an energy balance that does not close. `finer`: the key
/// whose smaller value makes the run's steps finer (fineness_key()). Energies are compared with the greatest that passed
/// within the run, which may be gone at its end.
void warn(Result& result, Family family, std::string_view finer);

/// Fails a finished run of an impact law whose surfaces lay deeper in each other than their contact's measure, a clearance or
/// a radius: past it the journal is outside its bearing, and what followed is of another mechanism. Contact laws yield, and
/// are doubted by warn().
void refuse_too_deep(Result& result, Family family, std::string_view finer);

/// Fails an ending whose state or energies are not finite: such a result is refused, whatever made it.
void refuse_not_finite(Result& result);

}  // namespace freeplay
