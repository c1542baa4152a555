// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the damping factor
//
//     χ = 1/e
//
// Derived from the energy loss of an impact with low restitution; at e = 1 the law still delivers
// 0.594.
// M. Gharib, Y. Hurmuzlu, A new contact force model for low coefficient of restitution impact, J.
// Appl. Mech. 79 (2012) 064506.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::gharib_hurmuzlu> : PointLaw {
  static constexpr std::string_view text = "gharib-hurmuzlu", formula = "χ = 1/e",
                                    source = "Gharib, Hurmuzlu, J. Appl. Mech. 79 (2012) 064506",
                                    range = "e near 0; effective e is at most 0.594";
  static constexpr bool positive_restitution = true;
  static double chi(double e) { return 1 / e; }
};

}  // namespace freeplay
