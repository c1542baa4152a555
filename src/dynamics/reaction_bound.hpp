// Bound of the friction in an ideal joint from the joint's own reaction λ = (λ_1, λ_2), the
// multipliers of its rows:
//
//     |f| ≤ μ(|u|) S(λ),     μ(s) = μ + (μ_s − μ) exp(−(s/v_S)²)   (Stribeck; else constant)
//
//     revolute        S = √(λ_1² + λ_2²)          f along the pin's surface, u = r (ω_j − ω_i):
//                                                 a couple r f
//     translational   S = |N|                     N = λ_1 across the guide, f along it, u = a·ḋ
//     with a length L S = |N_1| + |N_2| = max(|N|, 2|M|/L)
//
// The ends of the slider, at ±L/2 along the axis, share N and the guide's couple M = λ_2:
// N_1 + N_2 = N and (N_2 − N_1) L/2 = M. S is a norm (a seminorm if the couple is neglected), so
// |S(a) − S(b)| ≤ S(a − b). This property decides whether the friction is unique
// (formulations/contact/coupled_friction.hpp). In time steps λ are impulses, and the bound is one
// of an impulse. Source of μ(s) with exponent 2: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de
// Wit, Automatica 30 (1994) 1083.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace freeplay {

struct ReactionBound {
  int row = -1;      ///< first of the joint's two constraint rows
  int element = -1;  ///< index of the joint in Mechanism::joints
  bool pin = false;  ///< whether the joint is revolute
  /// 1/m, 2/L of a translational joint with a slider length; 0: the couple is neglected
  double couple = 0;
  double friction = 0;  ///< μ of sliding
  double more = 0;      ///< μ_s − μ, ≥ 0
  double stribeck = 1;  ///< m/s, v_S

  double support(double a, double b) const {
    return pin ? std::hypot(a, b) : std::max(std::abs(a), couple * std::abs(b));
  }
  double support(const double* lambda) const { return support(lambda[row], lambda[row + 1]); }
  /// ∂S/∂(λ_1, λ_2); at a kink of S, the derivative of one side.
  std::array<double, 2> slope(double a, double b) const {
    if (pin) {
      const double S = std::hypot(a, b);
      return S > 0 ? std::array{a / S, b / S} : std::array{0.0, 0.0};
    }
    if (couple * std::abs(b) > std::abs(a)) return {0, std::copysign(couple, b)};
    return {std::copysign(1.0, a), 0};
  }
  /// μ(|u|)
  template <class T>
  T coefficient(const T& u) const {
    if (more == 0) return T(friction);
    using std::exp;
    const T x = u / stribeck;
    return friction + more * exp(-x * x);
  }
};

}  // namespace freeplay
