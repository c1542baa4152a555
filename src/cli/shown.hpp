// An error as tables show it.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace freeplay::cli {

/// Two digits; a dash for what is not finite.
inline std::string shown(double x) { return std::isfinite(x) ? fmt::format("{:.1e}", x) : std::string("-"); }

}  // namespace freeplay::cli
