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

  /// Whether the stages of a column S differ from the embedded formula of third order by so much that the
  /// result of fifth order may be wrong by more than about 1e-8. `slope(i)`: derivatives of stage i; n:
  /// coordinates, which rates follow. `floor`: negligible derivatives of coordinates and of rates.
  template <class Slope>
  static bool varies_fast(const std::vector<double>& S, double h, std::size_t n, const double (&floor)[2],
                          Slope slope) {
    // The weights fulfil all conditions of third order, since stages 3 and 4 have stage order 2.
    constexpr double third[6] = {7.0 / 72, 0, 4.0 / 9, 11.0 / 24, 0, 0};
    constexpr double accepted = 3e-6;
    double error[2] = {}, size[2] = {floor[0], floor[1]};
    for (std::size_t k = 0; k < 2 * n; ++k) {
      double e = 0;
      for (std::size_t i = 0; i < 6; ++i) e += (b[i] - third[i]) * slope(i)[k];
      const auto rate = static_cast<std::size_t>(k >= n);
      error[rate] = std::max(error[rate], std::abs(h * e));
      size[rate] = std::max({size[rate], std::abs(S[k]), std::abs(h * slope(0)[k])});
    }
    size[0] = std::max(size[0], h * size[1]);
    return error[0] > accepted * size[0] || error[1] > accepted * size[1];
  }
};

}  // namespace freeplay
