// Line contact law of a journal inside a bearing of length L (law.hpp):
//
//     F = 2E* ΔR L π b²(b² + 1)/[2 − ln(b² + 1) − 2b⁴],   b² = δ/(2ΔR + δ)
//
// A. Persson, On the stress distribution of cylindrical elastic bodies in contact, Chalmers 1964;
// M. Ciavarella, P. Decuzzi, Int. J. Solids Struct. 38 (2001). b = tan(ε/2), ε the contact angle of
// the overlap, cos ε = ΔR/(ΔR + δ).
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::persson> : LineLaw {
  static constexpr std::string_view text = "persson", formula = "F = 2E*ΔRLπb²(b²+1)/[2−ln(b²+1)−2b⁴]",
                                    source = "Persson (1964); Ciavarella, Decuzzi (2001)",
                                    range = "δ < 10.09 ΔR; like materials";
  static ElasticLaw elastic(const LineContact& c) {
    return {ElasticLaw::Kind::persson, 2 * c.line(), 1, c.clearance, 0};
  }
};

}  // namespace freeplay
