// Line contact law of a journal inside a bearing of length L (law.hpp):
//
//     δ = f [ln(4ΔR/f) − 1],   f = F/(π E* L)
//
// K. L. Johnson, Contact Mechanics, Cambridge 1985.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::johnson> : LineLaw {
  static constexpr std::string_view text = "johnson", formula = "δ = f [ln(4ΔR/f) − 1]",
                                    source = "Johnson, Contact Mechanics (1985)", range = "δ < 0.541 ΔR";
  static ElasticLaw elastic(const LineContact& c) {
    return {ElasticLaw::Kind::logarithmic, c.line(), 1, c.clearance, -1};
  }
};

}  // namespace freeplay
