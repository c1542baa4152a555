// Line contact law of a journal inside a bearing of length L (law.hpp):
//
//     δ = f [ln(4ΔR/f) + 1],   f = F/(π E* L)
//
// ESDU 78035, Contact phenomena I: stresses, deflections and contact dimensions for normally loaded
// unlubricated elastic components, Engineering Sciences Data Unit, 1978.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::esdu> : LineLaw {
  static constexpr std::string_view text = "esdu-78035", formula = "δ = f [ln(4ΔR/f) + 1]",
                                    source = "ESDU 78035 (1978)", range = "δ < 4 ΔR";
  static ElasticLaw elastic(const LineContact& c) {
    return {ElasticLaw::Kind::logarithmic, c.line(), 1, c.clearance, 1};
  }
};

}  // namespace freeplay
