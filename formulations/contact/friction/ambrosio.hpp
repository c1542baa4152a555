// Friction law F_T = −F_N c(v) (friction_law.hpp) with the coefficient
//
//     c = 0 below v₀,   μ(|v| − v₀)/(v₁ − v₀) between,   μ above v₁
//
// J. Ambrósio, Impact of rigid and flexible multibody systems: deformation description and contact
// models, in: Virtual Nonlinear Multibody Systems (2003).
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<FrictionLaw::ambrosio> : AnyFrictionLaw {
  static constexpr std::string_view text = "ambrosio",
                                    formula = "0 below v₀, μ(v − v₀)/(v₁ − v₀) up to v₁, then μ",
                                    source = "Ambrósio, Virtual Nonlinear Multibody Systems (2003)",
                                    range = "no stiction: a loaded contact creeps below v₀",
                                    keys = "friction_v0, friction_v1";
  static constexpr bool positive_v0 = false, v1_above_v0 = true;
  static std::array<double, 2> kinks(const FrictionParameters& p) { return {p.v0, p.v1}; }
  template <class T>
  static T coefficient(const FrictionParameters& p, const T& s, int n) {
    return n == 0 ? T(0) : n == 1 ? T(p.mu * (s - p.v0) / (p.v1 - p.v0)) : T(p.mu);
  }
};

}  // namespace freeplay
