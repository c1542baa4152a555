// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the damping factor
//
//     χ = 3(1 − e)/2
//
// K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact,
// J. Appl. Mech. 42 (1975) 440.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::hunt_crossley> : PointLaw {
  static constexpr std::string_view text = "hunt-crossley", formula = "χ = 3(1 − e)/2",
                                    source = "Hunt, Crossley, J. Appl. Mech. 42 (1975) 440",
                                    range = "e near 1";
  static double chi(double e) { return 1.5 * (1 - e); }
};

}  // namespace freeplay
