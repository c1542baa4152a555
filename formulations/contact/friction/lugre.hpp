// LuGre friction law F_T = −F_N c(v, z) (friction_law.hpp) with the coefficient
//
//     c = σ₀ z + σ₁ ż + σ₂ v,   ż = v − |v| z/g,   g = [μ + (μ_s − μ) e^(−(v/v₀)²)]/σ₀
//
// The deflection z (m) of the bristle is an additional state variable. The parameters are the
// kinetic and static coefficients μ and μ_s, the Stribeck velocity v₀ (m/s), the bristle's
// stiffness σ₀ (1/m) and damping σ₁ (s/m), and the viscous coefficient σ₂ (s/m). σ₀, σ₁ and σ₂ are
// per unit of F_N.
// Source: C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, A new model for control of
// systems with friction, IEEE Trans. Autom. Control 40 (1995) 419.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<FrictionLaw::lugre> : AnyFrictionLaw {
  static constexpr std::string_view
      text = "lugre",
      formula = "σ₀z + σ₁ż + σ₂v with the bristle's ż = v − |v|z/g, g = [μ + (μ_s − μ)e^(−(v/v₀)²)]/σ₀",
      source = "Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995) 419",
      range = "stiction by bristles; stiff",
      keys = "friction_v0, friction_static, friction_viscous, bristle_stiffness, bristle_damping";
  static constexpr bool bristle = true, kink_at_rest = true;
  static constexpr double FrictionParameters::*stribeck = &FrictionParameters::v0;
  template <class T>
  static T coefficient(const FrictionParameters& p, const T& v, const T& speed, const T& z) {
    return p.sigma0 * z + p.sigma1 * bristle_rate(p, v, speed, z) + p.viscous * v;
  }
  template <class T>
  static T bristle_rate(const FrictionParameters& p, const T& v, const T& speed, const T& z) {
    using std::exp;
    const T x = v / p.v0, g = (p.mu + (p.mu_static - p.mu) * exp(-x * x)) / p.sigma0;
    return g > 0 ? T(v - speed * z / g) : T(0);
  }
  static double steady_bristle(const FrictionParameters& p, double v) {
    const double x = v / p.v0, side = v < 0 ? -1 : v > 0 ? 1 : 0;
    return side * (p.mu + (p.mu_static - p.mu) * std::exp(-x * x)) / p.sigma0;
  }
};

}  // namespace freeplay
