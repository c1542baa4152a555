// Dormand and Prince's method for columns of derivatives along a motion.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace freeplay {

/// Dormand and Prince's coefficients of the six stages of the result of fifth order.
struct DormandPrince {
  static constexpr double c[6] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1};
  static constexpr double a[6][5] = {
      {},
      {1.0 / 5},
      {3.0 / 40, 9.0 / 40},
      {44.0 / 45, -56.0 / 15, 32.0 / 9},
      {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
      {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
  };
  static constexpr double b[6] = {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84};

  /// Weights of the differences from embedded results. Third order: by six stages; all conditions of this
  /// order hold, since stages 3 and 4 have stage order 2. Fourth order: the seventh stage is at the end of
  /// the step.
  static constexpr double third[6] = {b[0] - 7.0 / 72, 0, b[2] - 4.0 / 9, b[3] - 11.0 / 24, b[4], b[5]};
  static constexpr double fourth[7] = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                       -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
};

}  // namespace freeplay
