// Dimension of an expression's value from those of its names. Sums, comparisons, min, max and hypot
// need equal dimensions, logarithms and exponentials pure numbers, sines an angle or a pure number;
// an exponent is a number. A pure number and an angle can be added, and a product with another
// quantity loses the radian, so that omega * x is a speed.
#pragma once

#include <span>

#include "io/scene/quantity.hpp"
#include "study/settings/expression.hpp"

namespace freeplay {

/// `names`: of the names, in the order given to the expression. Throws std::invalid_argument with
/// the operation and both dimensions.
Dimension dimension_of(const Expression& expression, std::span<const Dimension> names);

}  // namespace freeplay
