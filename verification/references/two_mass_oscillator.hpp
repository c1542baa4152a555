// A vibro-impact oscillator with two degrees of freedom, whose periodic motions lose their
// stability on a torus (systems of this kind: Luo and Xie, J. Sound Vib. 213 (1998) 391). Closed
// form but for one matrix exponential, in extended precision. Units: SI.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <utility>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

/// Masses m₁ and m₂ at x₁ and x₂, springs and dampers k₁, d₁ from the ground to m₁ and k₂, d₂ from
/// m₁ to m₂, a force F sin(Ωt + τ) on m₁, and a stop x₁ ≤ 0 with the restitution e. One impact per
/// period T, at t = 0:
///
///     y = e^{At} c + p(t),   y = (x₁, x₂, ẋ₁, ẋ₂),   p: steady oscillation,
///     y(0) = J y(T),  J = diag(1, 1, −e, 1)   ⇒   (1 − J e^{AT}) c = (J − 1) p(0),
///
/// and x₁(0) = 0 determines τ. A small change of the state after one impact is multiplied by S
/// e^{AT} up to the state after the next, with S = J + (f⁺ − J f⁻) nᵀ/ẋ₁⁻, n = (1, 0, 0, 0) and the
/// derivatives f of y.
struct TwoMassOscillator {
  using Real = long double;
  using Matrix = std::array<std::array<Real, 4>, 4>;
  using Vector = std::array<Real, 4>;

  Real m1, m2, k1, k2, d1, d2, force, frequency, restitution;

  static Real pi() { return std::acos(-1.0L); }
  Real period() const { return 2 * pi() / frequency; }

  struct Motion {
    Real phase;              ///< τ
    Vector c, sine, cosine;  ///< p = sine · sin Ωt + cosine · cos Ωt
    /// Coefficients of λ⁴ + a₁ λ³ + a₂ λ² + a₃ λ + a₄, whose roots are the multipliers.
    std::array<Real, 5> polynomial;
  };
  Motion motion() const {
    // Steady oscillation Im(Y e^{i(Ωt + τ)}).
    using Complex = std::complex<Real>;
    const Complex iw(0, frequency);
    const Real w2 = frequency * frequency;
    const Complex a = k1 + k2 - m1 * w2 + iw * (d1 + d2), b = -k2 - iw * d2, d = k2 - m2 * w2 + iw * d2,
                  X1 = d * force / (a * d - b * b), X2 = -b * force / (a * d - b * b);
    const std::array<Complex, 4> Y{X1, X2, iw * X1, iw * X2};
    const Matrix E = exponential(period());
    // c = G p(0) for each column of the unit matrix.
    Matrix system = identity(), G{};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) system[i][j] -= jump(i) * E[i][j];
    for (int j = 0; j < 4; ++j) {
      auto triangle = system;
      Vector column{};
      column[j] = jump(j) - 1;
      eliminate(triangle, column);
      for (int i = 0; i < 4; ++i) G[i][j] = column[i];
    }
    Complex z = 0;  // x₁(0) = Im(z e^{iτ})
    for (int j = 0; j < 4; ++j) z += (G[0][j] + (j == 0)) * Y[j];
    Motion m{};
    m.phase = -std::arg(z);
    Vector rate{};
    for (int i = 0; i < 4; ++i) {
      const Complex turned = Y[i] * std::polar(Real(1), m.phase);
      m.sine[i] = turned.real();
      m.cosine[i] = turned.imag();
      rate[i] = frequency * turned.real();
    }
    m.c = times(G, m.cosine);
    const auto before = times(E, m.c);  // e^{AT} c
    const Matrix A = flow();
    auto f0 = times(A, m.c), f1 = times(A, before);
    for (int i = 0; i < 4; ++i) {
      f0[i] += rate[i];
      f1[i] += rate[i];
    }
    Matrix S{};
    for (int i = 0; i < 4; ++i) {
      S[i][i] = jump(i);
      S[i][0] += (f0[i] - jump(i) * f1[i]) / f1[0];
    }
    m.polynomial = characteristic(product(S, E));
    return m;
  }
  /// The state at the time t (s) after an impact.
  Vector at(const Motion& m, Real t) const {
    auto y = times(exponential(t), m.c);
    for (int i = 0; i < 4; ++i)
      y[i] += m.sine[i] * std::sin(frequency * t) + m.cosine[i] * std::cos(frequency * t);
    return y;
  }
  /// Zero if two multipliers have the product 1: Hurwitz's determinant of the polynomial in s with
  /// λ = (1 + s)/(1 − s).
  Real torus_condition() const {
    const auto [a0, a1, a2, a3, a4] = motion().polynomial;
    const Real b0 = a0 - a1 + a2 - a3 + a4, b1 = 4 * a0 - 2 * a1 + 2 * a3 - 4 * a4,
               b2 = 6 * a0 - 2 * a2 + 6 * a4, b3 = 4 * a0 + 2 * a1 - 2 * a3 - 4 * a4,
               b4 = a0 + a1 + a2 + a3 + a4;
    return b1 * b2 * b3 - b0 * b3 * b3 - b1 * b1 * b4;
  }
  /// The restitution between two values at which the condition holds, by bisection.
  Real torus(Real low, Real high) const {
    const auto condition = [&](Real e) {
      auto other = *this;
      other.restitution = e;
      return other.torus_condition();
    };
    const bool rising = condition(low) < 0;
    bisect(low, high, 80, [&](Real middle) { return (condition(middle) < 0) == rising; });
    return low;
  }

 private:
  Real jump(int i) const { return i == 2 ? -restitution : 1; }
  static Matrix identity() {
    Matrix I{};
    for (int i = 0; i < 4; ++i) I[i][i] = 1;
    return I;
  }
  Matrix flow() const {
    return {{{0, 0, 1, 0},
             {0, 0, 0, 1},
             {-(k1 + k2) / m1, k2 / m1, -(d1 + d2) / m1, d2 / m1},
             {k2 / m2, -k2 / m2, d2 / m2, -d2 / m2}}};
  }
  static Matrix product(const Matrix& a, const Matrix& b) {
    Matrix c{};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 4; ++k) c[i][j] += a[i][k] * b[k][j];
    return c;
  }
  static Vector times(const Matrix& a, const Vector& x) {
    Vector y{};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) y[i] += a[i][j] * x[j];
    return y;
  }
  /// e^{At} by its series at t/2ⁿ, squared n times.
  Matrix exponential(Real t) const {
    constexpr int squarings = 12, terms = 20;
    const Matrix A = flow();
    Matrix sum = identity(), term = identity();
    for (int k = 1; k < terms; ++k) {
      term = product(term, A);
      for (auto& row : term)
        for (auto& x : row) x *= std::ldexp(t, -squarings) / k;
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) sum[i][j] += term[i][j];
    }
    for (int k = 0; k < squarings; ++k) sum = product(sum, sum);
    return sum;
  }
  /// Faddeev and Le Verrier's recursion.
  static std::array<Real, 5> characteristic(const Matrix& a) {
    std::array<Real, 5> p{1};
    Matrix m{};
    for (int k = 1; k <= 4; ++k) {
      m = product(a, m);
      for (int i = 0; i < 4; ++i) m[i][i] += p[k - 1];
      Real trace = 0;
      const auto am = product(a, m);
      for (int i = 0; i < 4; ++i) trace += am[i][i];
      p[k] = -trace / k;
    }
    return p;
  }
};

}  // namespace freeplay::reference
