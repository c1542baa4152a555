// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the damping factor
//
//     χ = (1 − e²)/e
//
// Y. Gonthier, J. McPhee, C. Lange, J.-C. Piedbœuf, A regularized contact model with asymmetric
// damping and dwell-time dependent friction, Multibody Syst. Dyn. 11 (2004) 209.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::gonthier> : PointLaw {
  static constexpr std::string_view text = "gonthier", formula = "χ = (1 − e²)/e",
                                    source = "Gonthier et al., Multibody Syst. Dyn. 11 (2004) 209",
                                    range = "0 < e ≤ 1";
  static constexpr bool positive_restitution = true;
  static double chi(double e) { return (1 - e * e) / e; }
};

}  // namespace freeplay
