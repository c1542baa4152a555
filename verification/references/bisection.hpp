// Bisection.
#pragma once

namespace freeplay::reference {

/// Halves the interval from `low` to `high` so many times; `below`: whether a point is on the side
/// of `low` of the border.
template <class Real, class Below>
void bisect(Real& low, Real& high, int times, const Below& below) {
  for (int i = 0; i < times; ++i) {
    const Real middle = (low + high) / 2;
    (below(middle) ? low : high) = middle;
  }
}

}  // namespace freeplay::reference
