// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the damping factor
//
//     χ = 3(1 − e)/(2e)
//
// S. Hu, X. Guo, A dissipative contact force model for impact analysis in multibody dynamics,
// Multibody Syst. Dyn. 35 (2015) 131.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::hu_guo> : PointLaw {
  static constexpr std::string_view text = "hu-guo", formula = "χ = 3(1 − e)/(2e)",
                                    source = "Hu, Guo, Multibody Syst. Dyn. 35 (2015) 131",
                                    range = "0 < e ≤ 1";
  static constexpr bool positive_restitution = true;
  static double chi(double e) { return 3 * (1 - e) / (2 * e); }
};

}  // namespace freeplay
