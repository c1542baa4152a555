// Point contact law of Hertz, without damping (contact_law.hpp):
//
//     F = K δ^(3/2),   χ = 0
//
// H. Hertz, Über die Berührung fester elastischer Körper, J. reine angew. Math. 92 (1882) 156.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::hertz> : PointLaw {
  static constexpr std::string_view text = "hertz", formula = "χ = 0",
                                    source = "Hertz, J. reine angew. Math. 92 (1882) 156",
                                    range = "e = 1 only: no damping";
  static constexpr bool takes_restitution = false;
  static double chi(double) { return 0; }
};

}  // namespace freeplay
