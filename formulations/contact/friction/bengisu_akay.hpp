// Friction law F_T = −F_N c(v) (friction_law.hpp) with the coefficient
//
//     c = μ_s[1 − (|v|/v₀ − 1)²] up to v₀, then μ + (μ_s − μ) exp[−ξ(|v| − v₀)]
//
// M. T. Bengisu, A. Akay, Stability of friction-induced vibrations in multi-degree-of-freedom
// systems, J. Sound Vib. 171 (1994) 557.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<FrictionLaw::bengisu_akay> : AnyFrictionLaw {
  static constexpr std::string_view text = "bengisu-akay",
                                    formula =
                                        "μ_s[1 − (v/v₀ − 1)²] up to v₀, then μ + (μ_s − μ) e^(−ξ(v − v₀))",
                                    source = "Bengisu, Akay, J. Sound Vib. 171 (1994) 557", range = "μ_s ≥ μ",
                                    keys = "friction_v0, friction_static, friction_decay";
  static constexpr bool kink_at_rest = true;
  static std::array<double, 1> kinks(const FrictionParameters& p) { return {p.v0}; }
  template <class T>
  static T coefficient(const FrictionParameters& p, const T& s, int n) {
    using std::exp;
    return n == 1 ? T(p.mu_static * (1 - (s / p.v0 - 1) * (s / p.v0 - 1)))
                  : T(p.mu + (p.mu_static - p.mu) * exp(-p.decay * (s - p.v0)));
  }
};

}  // namespace freeplay
