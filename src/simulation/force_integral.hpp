// Impulses of forces that are known at instants: Gauss and Legendre's three points, of sixth order in the length
// of the piece, on the state's dense output.
#pragma once

#include <cmath>

#include "values/forces.hpp"

namespace freeplay {

/// Adds the impulse of source.forces(t, out) from a to b to `sum`. `at`: scratch of the same shape.
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
