// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the exact damping factor,
// from
//
//     χ(1 + e) = ln[(1 + χ)/(1 − χe)]
//
// The first integral of a free impact (see contact_law.hpp), solved for χ: the law delivers the
// requested restitution.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::exact> : PointLaw {
  static constexpr std::string_view text = "exact", formula = "χ(1 + e) = ln[(1 + χ)/(1 − χe)]",
                                    source = "first integral of a free impact", range = "0 < e ≤ 1";
  static constexpr bool positive_restitution = true;
  static double chi(double e) { return exact_damping_factor(e); }
};

}  // namespace freeplay
