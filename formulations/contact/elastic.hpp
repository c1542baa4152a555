// ElasticLaw: elastic part of a contact force, F_el(δ), for a journal inside a bearing. ΔR = c is
// the radial clearance, E* = E/(2(1 − ν²)) for equal materials, L the length of the bearing.
// f = F/(π E* L) has the dimension of a length.
//
//   hertz        F = K δ^(3/2),  K = (4/3) E* √(R_i R_j/ΔR)            point contact
//   power        F = K δⁿ
//   linear       F = K δ
//   logarithmic  δ = f [ln(4ΔR/f) + B]
//   liu          F = (π/2) L E* δ √(δ/[2(ΔR + δ)])
//   persson      F = E* ΔR L π b²(b² + 1)/[2 − ln(b² + 1) − 2b⁴],  b² = δ/(2ΔR + δ)
//   own          F(δ, 0, 1) of a user-defined law (mechanism/own_law.hpp)
//
// The file of each contact law, laws/NAME.hpp, names its elastic law and its source.
#pragma once

#include <cmath>

#include "mechanism/own_law.hpp"
#include "numerics/dual.hpp"

namespace freeplay {

struct ElasticLaw {
  enum class Kind { hertz, power, linear, logarithmic, liu, persson, own };
  Kind kind = Kind::hertz;
  /// K, N/m^n; for liu (π/2) L E* (N/m); for logarithmic and persson π E* L (N/m)
  double stiffness = 0;
  double exponent = 1.5;            ///< n of power
  double clearance = 0;             ///< ΔR, m
  double offset = 0;                ///< B of logarithmic
  const OwnLaw* outside = nullptr;  ///< function of own
  const char* contact = nullptr;    ///< name of the contact, passed to that function

  /// Whether F = K δⁿ with K = stiffness and n = exponent.
  bool is_power() const;
  /// Greatest δ (m) for which the law gives a force; infinite for most laws.
  double limit() const;
  /// F_el in N for δ ≥ 0 (m); NaN beyond limit().
  double force(double delta) const {
    if (kind == Kind::hertz) return stiffness * delta * std::sqrt(delta);
    return other_force(delta);
  }
  /// dF_el/dδ (N/m) for δ ≥ 0 (m); NaN beyond limit().
  double slope(double delta) const;
  template <int N>
  Dual<N> force(const Dual<N>& delta) const {
    return delta.chain(force(delta.value), slope(delta.value));
  }
  /// Total force of own, with its damping, clamped at zero.
  double own_force(double delta, double rate, double v0) const;
  /// Total force of own with its derivatives by central differences.
  template <class T, class V0>
  T own_force(const T& delta, const T& rate, const V0& v0) const;
  /// ∫ F_el dδ from 0 (J), in closed form where there is one, otherwise by quadrature.
  double energy(double delta) const;
  template <int N>
  Dual<N> energy(const Dual<N>& delta) const {
    return delta.chain(energy(delta.value), force(delta.value));
  }

 private:
  double other_force(double delta) const;
};

template <class T, class V0>
T ElasticLaw::own_force(const T& delta, const T& rate, const V0& v0) const {
  const double d = value_of(delta), r = value_of(rate), v = value_of(v0);
  // Differences of ∛ε times the size of each argument: rounding error and truncation error are then
  // of the same order.
  const auto slope_in = [](double x, double scale, auto f) {
    const double h = 6e-6 * scale;
    return (f(x + h) - f(x - h)) / (2 * h);
  };
  T f = own_force(d, r, v);
  f += slope_in(d, d, [&](double x) { return own_force(x, r, v); }) * (delta - T(d));
  f += slope_in(r, std::abs(r) + v, [&](double x) { return own_force(d, x, v); }) * (rate - T(r));
  f += slope_in(v, v, [&](double x) { return own_force(d, r, x); }) * (T(v0) - T(v));
  return f;
}

}  // namespace freeplay
