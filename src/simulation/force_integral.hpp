// Impulses of forces that are known at instants, by Gauss–Legendre quadrature with three points on
// the dense output; the error is of sixth order in the length of the interval.
#pragma once

#include <cmath>

#include "values/forces.hpp"

namespace freeplay {

/// Adds the impulse of source.forces(t, out) from a to b to `sum`. `at` is scratch of the same
/// size.
template <class Source>
void integrate_forces(Source& source, double a, double b, Forces& at, Forces& sum) {
  if (!(b > a)) return;
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a), off = std::sqrt(0.6) * half;
  const auto take = [&](double t, double weight) {
    source.forces(t, at);
    sum.add(weight * half, at);
  };
  take(middle - off, 5.0 / 9);
  take(middle, 8.0 / 9);
  take(middle + off, 5.0 / 9);
}

}  // namespace freeplay
