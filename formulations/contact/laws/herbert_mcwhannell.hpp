// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the damping factor
//
//     χ = 6(1 − e)/[(2e − 1)² + 3]
//
// R. G. Herbert, D. C. McWhannell, Shape and frequency composition of pulses from an impact pair,
// J. Eng. Ind. 99 (1977) 671.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::herbert_mcwhannell> : PointLaw {
  static constexpr std::string_view text = "herbert-mcwhannell", formula = "χ = 6(1 − e)/[(2e − 1)² + 3]",
                                    source = "Herbert, McWhannell, J. Eng. Ind. 99 (1977) 671",
                                    range = "e near 1";
  static double chi(double e) { return 6 * (1 - e) / ((2 * e - 1) * (2 * e - 1) + 3); }
};

}  // namespace freeplay
