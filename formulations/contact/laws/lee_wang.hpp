// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the damping factor
//
//     χ = 3(1 − e)/4
//
// T. W. Lee, A. C. Wang, On the dynamics of intermittent-motion mechanisms, J. Mech. Transm. Autom.
// Des. 105 (1983) 534.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::lee_wang> : PointLaw {
  static constexpr std::string_view text = "lee-wang", formula = "χ = 3(1 − e)/4",
                                    source = "Lee, Wang, J. Mech. Transm. Autom. Des. 105 (1983) 534",
                                    range = "e near 1";
  static double chi(double e) { return 0.75 * (1 - e); }
};

}  // namespace freeplay
