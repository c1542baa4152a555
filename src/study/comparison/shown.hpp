// Text of an error in tables.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace freeplay {

/// Two significant digits; a dash if x is not finite.
inline std::string shown(double x) { return std::isfinite(x) ? fmt::format("{:.1e}", x) : std::string("-"); }

}  // namespace freeplay
