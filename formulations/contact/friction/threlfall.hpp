// Friction law F_T = −F_N c(v) (friction_law.hpp) with the coefficient
//
//     c = μ(1 − exp(−3|v|/v₀)) up to v₀, then constant at its value there, 0.9502 μ
//
// The source rounds this value to 0.95 μ, with a jump at v₀.
// D. C. Threlfall, The inclusion of Coulomb friction in mechanisms programs with particular
// reference to DRAM, Mech. Mach. Theory 13 (1978) 475.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<FrictionLaw::threlfall> : AnyFrictionLaw {
  static constexpr std::string_view text = "threlfall",
                                    formula = "μ(1 − e^(−3v/v₀)) up to v₀, then its value there, 0.9502 μ",
                                    source = "Threlfall, Mech. Mach. Theory 13 (1978) 475",
                                    range = "never more than 0.9502 μ", keys = "friction_v0";
  static constexpr bool kink_at_rest = true;
  static std::array<double, 1> kinks(const FrictionParameters& p) { return {p.v0}; }
  template <class T>
  static T coefficient(const FrictionParameters& p, const T& s, int n) {
    using std::exp;
    return p.mu * (1 - exp(n == 1 ? T(-3 * s / p.v0) : T(-3)));
  }
};

}  // namespace freeplay
