// Elastic part of a contact force, F_el(δ), for a journal inside a bearing. ΔR = c, E* = E/(2(1 − ν²)) for like
// materials, L the bearing's length; f = F/(π E* L) has the dimension of a length.
//
//   hertz        F = K δ^(3/2),  K = (4/3) E* √(R_i R_j/ΔR)            point contact
//   power        F = K δⁿ
//   linear       F = K δ
//   logarithmic  δ = f [ln(4ΔR/f) + B]
//   liu          F = (π/2) L E* δ √(δ/[2(ΔR + δ)])
//   persson      F = E* ΔR L π b²(b² + 1)/[2 − ln(b² + 1) − 2b⁴],  b² = δ/(2ΔR + δ)
//
// Which law takes which, and its source, stand in contact/NAME.hpp.
#pragma once

#include <cmath>

#include "numerics/dual.hpp"

namespace freeplay {

struct ElasticLaw {
  enum class Kind { hertz, power, linear, logarithmic, liu, persson };
  Kind kind = Kind::hertz;
  double stiffness = 0;   ///< K, N/m^n; of liu (π/2) L E* (N/m); of logarithmic and persson π E* L (N/m)
  double exponent = 1.5;  ///< n of power
  double clearance = 0;   ///< ΔR, m
  double offset = 0;      ///< B of logarithmic

  /// Whether F = K δⁿ with K = stiffness and n = exponent.
  bool is_power() const;
  /// Greatest δ for which the law gives a force (m); infinite for most.
  double limit() const;
  /// F_el in N for δ ≥ 0 (m); NaN beyond limit().
  double force(double delta) const {
    if (kind == Kind::hertz) return stiffness * delta * std::sqrt(delta);
    return other_force(delta);
  }
  /// dF_el/dδ (N/m), likewise.
  double slope(double delta) const;
  template <int N>
  Dual<N> force(const Dual<N>& delta) const {
    return delta.chain(force(delta.value), slope(delta.value));
  }
  /// ∫ F_el dδ from 0 (J), in closed form where there is one, else by quadrature.
  double energy(double delta) const;
  template <int N>
  Dual<N> energy(const Dual<N>& delta) const {
    return delta.chain(energy(delta.value), force(delta.value));
  }

 private:
  double other_force(double delta) const;
};

}  // namespace freeplay
