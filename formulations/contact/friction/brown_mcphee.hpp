// Friction law F_T = −F_N c(v) (friction_law.hpp) with the coefficient
//
//     c = μ tanh(4x) + (μ_s − μ) x/(x²/4 + ¾)² + σ₂ v,   x = v/v₀
//
// P. Brown, J. McPhee, A continuous velocity-based friction model for dynamics and control with
// physically meaningful parameters, J. Comput. Nonlinear Dyn. 11 (2016) 054502.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<FrictionLaw::brown_mcphee> : AnyFrictionLaw {
  static constexpr std::string_view text = "brown-mcphee",
                                    formula = "μ tanh(4x) + (μ_s − μ) x/(x²/4 + ¾)² + σ₂v, x = v/v₀",
                                    source = "Brown, McPhee, J. Comput. Nonlinear Dyn. 11 (2016) 054502",
                                    range = "smooth; no stiction",
                                    keys = "friction_v0, friction_static, friction_viscous";
  template <class T>
  static T coefficient(const FrictionParameters& p, const T& v, int) {
    using std::tanh;
    const T x = v / p.v0, d = 0.25 * x * x + 0.75;
    return p.mu * tanh(4 * x) + (p.mu_static - p.mu) * x / (d * d) + p.viscous * v;
  }
};

}  // namespace freeplay
