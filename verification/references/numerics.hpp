// Numerical methods of the references, which share nothing with the program's: bisection, Gaussian
// elimination, and one step of a Runge–Kutta method of order 8.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

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

// Gaussian elimination: solves a x = b for a square matrix of any container of rows. With pivots,
// rows are exchanged for the greatest entry of each column; a symmetric positive definite matrix
// needs none.

enum class Pivots { rows, none };

/// Replaces b by x, and a by its triangular factor; false if a is singular.
template <class Matrix, class Vector>
bool eliminate(Matrix& a, Vector& b, Pivots pivots = Pivots::rows) {
  const std::size_t n = b.size();
  for (std::size_t c = 0; c < n; ++c) {
    std::size_t p = c;
    for (std::size_t r = c + 1; r < n && pivots == Pivots::rows; ++r)
      if (std::abs(a[r][c]) > std::abs(a[p][c])) p = r;
    if (a[p][c] == 0) return false;
    std::swap(a[p], a[c]), std::swap(b[p], b[c]);
    for (std::size_t r = c + 1; r < n; ++r) {
      const auto factor = a[r][c] / a[c][c];
      for (std::size_t k = c; k < n; ++k) a[r][k] -= factor * a[c][k];
      b[r] -= factor * b[c];
    }
  }
  for (std::size_t c = n; c-- > 0;) {
    for (std::size_t k = c + 1; k < n; ++k) b[c] -= a[c][k] * b[k];
    b[c] /= a[c][c];
  }
  return true;
}

// One step of the explicit Runge–Kutta method of order 8 with 11 stages of Cooper and Verner,
// ẏ = f(t, y):
//
//     k_i = f(t + c_i h, y + h Σ_{j<i} a_ij k_j),  y(t + h) ≈ y + h Σ b_i k_i,  local error O(h⁹).
//
// Its coefficients are exact in √21, so it serves any floating-point type. Used by the slider-crank
// oracle.
// Sign convention: h may be negative. Units: those of y and t.
// Source: Cooper and Verner, Some explicit Runge–Kutta methods of high order, SIAM J. Numer. Anal.
// 9 (1972) 389; the order is measured in the test.

template <class Real>
struct CooperVerner {
  static constexpr std::size_t stages = 11;
  std::array<std::array<Real, stages>, stages> a{};
  std::array<Real, stages> b{}, c{};

  CooperVerner() {
    using std::sqrt;
    const Real q = sqrt(Real(21));
    const auto row = [this](std::size_t i, std::array<Real, stages> values) { a[i] = values; };
    row(1, {Real(1) / 2});
    row(2, {Real(1) / 4, Real(1) / 4});
    row(3, {Real(1) / 7, (-7 - 3 * q) / 98, (21 + 5 * q) / 49});
    row(4, {(11 + q) / 84, 0, (18 + 4 * q) / 63, (21 - q) / 252});
    row(5, {(5 + q) / 48, 0, (9 + q) / 36, (-231 + 14 * q) / 360, (63 - 7 * q) / 80});
    row(6, {(10 - q) / 42, 0, (-432 + 92 * q) / 315, (633 - 145 * q) / 90, (-504 + 115 * q) / 70,
            (63 - 13 * q) / 35});
    row(7, {Real(1) / 14, 0, 0, 0, (14 - 3 * q) / 126, (13 - 3 * q) / 63, Real(1) / 9});
    row(8, {Real(1) / 32, 0, 0, 0, (91 - 21 * q) / 576, Real(11) / 72, (-385 - 75 * q) / 1152,
            (63 + 13 * q) / 128});
    row(9, {Real(1) / 14, 0, 0, 0, Real(1) / 9, (-733 - 147 * q) / 2205, (515 + 111 * q) / 504,
            (-51 - 11 * q) / 56, (132 + 28 * q) / 245});
    row(10, {0, 0, 0, 0, (-42 + 7 * q) / 18, (-18 + 28 * q) / 45, (-273 - 53 * q) / 72, (301 + 53 * q) / 72,
             (28 - 28 * q) / 45, (49 - 7 * q) / 18});
    b = {Real(1) / 20, 0, 0, 0, 0, 0, 0, Real(49) / 180, Real(16) / 45, Real(49) / 180, Real(1) / 20};
    c = {0,
         Real(1) / 2,
         Real(1) / 2,
         (7 + q) / 14,
         (7 + q) / 14,
         Real(1) / 2,
         (7 - q) / 14,
         (7 - q) / 14,
         Real(1) / 2,
         (7 + q) / 14,
         1};
  }

  template <std::size_t N, class Rate>
  std::array<Real, N> step(const Rate& f, Real t, const std::array<Real, N>& y, Real h) const {
    std::array<std::array<Real, N>, stages> k;
    for (std::size_t i = 0; i < stages; ++i) {
      std::array<Real, N> at = y;
      for (std::size_t j = 0; j < i; ++j) {
        if (a[i][j] == 0) continue;
        for (std::size_t n = 0; n < N; ++n) at[n] += h * a[i][j] * k[j][n];
      }
      k[i] = f(t + c[i] * h, at);
    }
    std::array<Real, N> next = y;
    for (std::size_t i = 0; i < stages; ++i) {
      if (b[i] == 0) continue;
      for (std::size_t n = 0; n < N; ++n) next[n] += h * b[i] * k[i][n];
    }
    return next;
  }
};

}  // namespace freeplay::reference
