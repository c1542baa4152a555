// Line contact law of a journal inside a bearing of length L (law.hpp):
//
//     δ = f [⅔ + ln(4R_i/b) + ln(4R_j/b)] = f [ln(4ΔR/f) + ⅔ − ln 4],   f = F/(π E* L),
//
// with the full width of the contact, b = 2√(4 F R/(π E* L)), R = R_i R_j/ΔR
// (docs/theory/penalty.md gives the reason). E. I. Radzimovsky, Stress distribution and strength
// condition of two rolling cylinders pressed together, Univ. Illinois Eng. Exp. Station Bull. 408
// (1953).
#pragma once

#include <cmath>

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::radzimovsky> : LineLaw {
  static constexpr std::string_view text = "radzimovsky", formula = "δ = f [⅔ + ln(4R_i/b) + ln(4R_j/b)]",
                                    source = "Radzimovsky, Univ. Illinois Bull. 408 (1953)",
                                    range = "δ < 0.716 ΔR; b is the full width of contact";
  static ElasticLaw elastic(const LineContact& c) {
    return {ElasticLaw::Kind::logarithmic, c.line(), 1, c.clearance, 2.0 / 3 - std::log(4)};
  }
};

}  // namespace freeplay
