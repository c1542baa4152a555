// Central differences of fourth order of a smooth function of one variable s at s = 0,
//
//     f'(0) ≈ [8 (f(h) − f(−h)) − (f(2h) − f(−2h))]/(12 h),    error h⁴ f⁽⁵⁾/30,
//
// and a test for kinks within 2h. With E(s) = f(s) − 2 f(0) + f(−s), a smooth function has
// E(2h) = 4 E(h) up to h⁴, a kink at 0 has E(2h) = 2 E(h). A kink at 2h/3 has E(2h) = 4 E(h), too, but
// there the slopes over ±h and ±2h differ by a sixth of the kink. The functions are closed forms at a fixed
// mode (forces, an impact map, a gap), never a trajectory.
//
// Rounding errors violate these equations by an amount that does not depend on h, kinks by one that falls
// with h, curvature by one that falls faster; is_rounding() compares two spacings.
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
  std::vector<double> excess = {};  ///< by which each component violates the equations of a smooth function
  double rounding = 0;              ///< excess that rounding of the greatest value explains
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
  d.excess.resize(size);
  double greatest = 0, change = 0;
  for (const double y : centre) greatest = std::max(greatest, std::abs(y));
  d.rounding = 1e-13 * greatest;
  for (std::size_t k = 0; k < size; ++k) change = std::max(change, std::abs(f[3][k] - f[0][k]));
  for (std::size_t k = 0; k < size; ++k) {
    const double inner = f[2][k] - f[1][k], outer = f[3][k] - f[0][k];
    d.slope[k] = (8 * inner - outer) / (12 * h);
    const double near = f[2][k] - 2 * centre[k] + f[1][k], far = f[3][k] - 2 * centre[k] + f[0][k];
    // Relative slope changes below 1e-5 are not seen; they do not matter to the digits that count. With 1e-3
    // in the second line, the term of fifth order is below 1e-7.
    const double turns = std::abs(inner) + std::abs(outer);
    d.excess[k] = std::fmax(std::abs(far - 4 * near) - 1e-5 * turns - 0.02 * std::abs(far),
                            std::abs(outer - 2 * inner) - 1e-3 * turns - 1e-4 * change);
    if (!(d.excess[k] <= d.rounding)) d.smooth = false;
  }
  return d;
}

/// Whether rounding explains that a difference is not smooth, by one whose spacing is smaller by `ratio`: a
/// kink would violate the equations there by at most this part.
inline bool is_rounding(const Difference& wide, const Difference& close, double ratio) {
  for (std::size_t k = 0; k < wide.excess.size(); ++k)
    if (!std::isfinite(close.slope[k]) ||
        !(wide.excess[k] <= std::max(wide.rounding, close.excess[k] / (3 * ratio))))
      return false;
  return true;
}

}  // namespace freeplay
