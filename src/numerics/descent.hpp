// Newton's method for a minimum of a function on an interval.
#pragma once

#include <cmath>

namespace freeplay {

/// The minimum in [a, b] near x. A place has the members `phi`, `bend` (the second derivative) and `Rate` (the first);
/// look(phi) evaluates it. A step that would leave the interval ends at its end, or in its middle if the minimum is
/// known to lie before that end; after one of at most `last_step` the next is below rounding.
template <auto Rate, class Place, class Look>
Place descend(Place x, double a, double b, double last_step, const Look& look) {
  bool after_a = false, before_b = false;
  for (int i = 0; i < 100 && x.*Rate != 0; ++i) {
    if (x.*Rate > 0)
      b = x.phi, before_b = true;
    else
      a = x.phi, after_a = true;
    double to = x.bend > 0 ? x.phi - x.*Rate / x.bend : x.*Rate > 0 ? a : b;
    if (to > b) to = before_b ? 0.5 * (a + b) : b;
    if (to < a) to = after_a ? 0.5 * (a + b) : a;
    const double step = std::abs(to - x.phi);
    if (step <= 1e-16 * (1 + std::abs(to))) break;
    x = look(to);
    if (step <= last_step) break;
  }
  return x;
}

}  // namespace freeplay
