// Dimensions of units as powers of kg, m, s, rad and A, for arithmetic with quantities. The radian
// is a base unit here, as in quantity.hpp.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace freeplay {

/// Powers of kg, m, s, rad and A. A root makes fractions.
using Dimension = std::array<double, 5>;

/// Dimension of a unit in the spelling of quantity.hpp; empty for an unknown unit.
std::optional<Dimension> dimension_of(std::string_view unit);
/// SI unit of a dimension as it is usually written, "N" for kg m s^-2; "" for a pure number.
std::string si_unit(const Dimension& dimension);
/// Name of a dimension for messages, "a force (N)".
std::string name_of(const Dimension& dimension);

}  // namespace freeplay
