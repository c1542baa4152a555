// Friction law F_T = −F_N c(v) (friction_law.hpp) with the coefficient
//
//     c = [μ + (μ_s − μ) exp(−(v/v₁)²)] tanh(|v|/v₀) + σ₂ |v|
//
// Coulomb, Stribeck and viscous friction, smooth at rest. v₁ is Stribeck's speed; the Stribeck
// exponent is 2 here.
// S. Andersson, A. Söderberg, S. Björklund, Friction models for sliding dry, boundary and mixed
// lubricated contacts, Tribol. Int. 40 (2007) 580.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<FrictionLaw::andersson> : AnyFrictionLaw {
  static constexpr std::string_view text = "andersson",
                                    formula = "[μ + (μ_s − μ) e^(−(v/v₁)²)] tanh(v/v₀) + σ₂v",
                                    source = "Andersson, Söderberg, Björklund, Tribol. Int. 40 (2007) 580",
                                    range = "smooth; no stiction",
                                    keys = "friction_v0, friction_v1, friction_static, friction_viscous";
  static constexpr double FrictionParameters::*stribeck = &FrictionParameters::v1;
  template <class T>
  static T coefficient(const FrictionParameters& p, const T& v, int) {
    using std::exp, std::tanh;
    const T x = v / p.v1;
    return (p.mu + (p.mu_static - p.mu) * exp(-x * x)) * tanh(v / p.v0) + p.viscous * v;
  }
};

}  // namespace freeplay
