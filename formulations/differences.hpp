// Central differences of fourth order of a smooth function of one variable s at s = 0,
//
//     f'(0) ≈ [8 (f(h) − f(−h)) − (f(2h) − f(−2h))]/(12 h),    error h⁴ f⁽⁵⁾/30,
//
// and a test for kinks within 2h. With E(s) = f(s) − 2 f(0) + f(−s), a smooth function has
// E(2h) = 4 E(h) up to h⁴, a kink at 0 has E(2h) = 2 E(h). A kink at 2h/3 has E(2h) = 4 E(h), too, but
// there the slopes over ±h and ±2h differ by a sixth of the kink. The functions are closed forms at a fixed
// mode (forces, an impact map, a gap), never a trajectory.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace freeplay {

/// A derivative, and whether the function is smooth within the differences.
struct Difference {
  std::vector<double> slope;
  bool smooth = true;
};

/// Multiples of the spacing h at which functions are evaluated.
inline constexpr std::array<int, 4> difference_places{-2, -1, 1, 2};

/// `value(i)`: the function at difference_places[i] h; `centre`: its value at 0.
template <class F>
Difference difference(double h, const std::vector<double>& centre, F value) {
  std::array<std::vector<double>, 4> f;
  for (std::size_t i = 0; i < f.size(); ++i) f[i] = value(i);
  Difference d;
  const std::size_t size = centre.size();
  d.slope.resize(size);
  double greatest = 0, change = 0;
  for (const double y : centre) greatest = std::max(greatest, std::abs(y));
  for (std::size_t k = 0; k < size; ++k) change = std::max(change, std::abs(f[3][k] - f[0][k]));
  for (std::size_t k = 0; k < size; ++k) {
    const double inner = f[2][k] - f[1][k], outer = f[3][k] - f[0][k];
    d.slope[k] = (8 * inner - outer) / (12 * h);
    const double near = f[2][k] - 2 * centre[k] + f[1][k], far = f[3][k] - 2 * centre[k] + f[0][k];
    const double rounding = 1e-13 * greatest;
    // Relative slope changes below 1e-5 are not seen; they do not matter to the digits that count.
    if (!(std::abs(far - 4 * near) <=
          rounding + 1e-5 * (std::abs(inner) + std::abs(outer)) + 0.02 * std::abs(far)))
      d.smooth = false;
    // With 1e-3 here, the term of fifth order is below 1e-7.
    if (!(std::abs(outer - 2 * inner) <=
          rounding + 1e-3 * (std::abs(inner) + std::abs(outer)) + 1e-4 * change))
      d.smooth = false;
  }
  return d;
}

}  // namespace freeplay
