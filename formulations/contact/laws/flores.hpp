// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the damping factor
//
//     χ = 8(1 − e)/(5e)
//
// P. Flores, M. Machado, M. T. Silva, J. M. Martins, On the continuous contact force models for
// soft materials in multibody dynamics, Multibody Syst. Dyn. 25 (2011) 357.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::flores> : PointLaw {
  static constexpr std::string_view text = "flores", formula = "χ = 8(1 − e)/(5e)",
                                    source = "Flores et al., Multibody Syst. Dyn. 25 (2011) 357",
                                    range = "0 < e ≤ 1";
  static constexpr bool positive_restitution = true;
  static double chi(double e) { return 8 * (1 - e) / (5 * e); }
};

}  // namespace freeplay
