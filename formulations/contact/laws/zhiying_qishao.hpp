// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the damping factor
//
//     χ = ¾(1 − e²) exp[2(1 − e)]
//
// Zhiying, Qishao (2006): Lankarani and Nikravesh's factor with a correction for low restitution.
#pragma once

#include <cmath>

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::zhiying_qishao> : PointLaw {
  static constexpr std::string_view text = "zhiying-qishao", formula = "χ = ¾(1 − e²) exp[2(1 − e)]",
                                    source = "Zhiying, Qishao (2006)", range = "0.3 ≤ e ≤ 1";
  static double chi(double e) { return 0.75 * (1 - e * e) * std::exp(2 * (1 - e)); }
};

}  // namespace freeplay
