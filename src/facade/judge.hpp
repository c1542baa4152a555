// What a finished run is told about itself.
#pragma once

#include "values/family.hpp"
#include "values/result.hpp"

namespace freeplay {

/// Adds notes on what makes a result doubtful: a journal deep in its wall, an energy balance that does not close. Energies
/// are judged by the greatest that passed within the run, which may be gone at its end.
void warn(Result& result, Family family);

/// Fails an ending whose state or energies are not finite: such a result is refused, whatever made it.
void refuse_not_finite(Result& result);

}  // namespace freeplay
