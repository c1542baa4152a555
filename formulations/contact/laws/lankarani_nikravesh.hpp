// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the damping factor
//
//     χ = 3(1 − e²)/4
//
// H. M. Lankarani, P. E. Nikravesh, A contact force model with hysteresis damping for impact
// analysis of multibody systems, J. Mech. Des. 112 (1990) 369.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::lankarani_nikravesh> : PointLaw {
  static constexpr std::string_view text = "lankarani-nikravesh", formula = "χ = 3(1 − e²)/4",
                                    source = "Lankarani, Nikravesh, J. Mech. Des. 112 (1990) 369",
                                    range = "e near 1; effective e is at least 0.663";
  static double chi(double e) { return 0.75 * (1 - e * e); }
};

}  // namespace freeplay
