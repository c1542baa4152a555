// Line contact law of a journal inside a bearing of length L (law.hpp):
//
//     F = (π/2) L E* δ √(δ/[2(ΔR + δ)])
//
// C. Liu, K. Zhang, R. Yang, The compliance contact model of cylindrical joints with clearances,
// Acta Mech. Sin. 21 (2005) 451.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::liu> : LineLaw {
  static constexpr std::string_view text = "liu", formula = "F = (π/2) L E* δ √(δ/[2(ΔR + δ)])",
                                    source = "Liu et al. (2005)", range = "all δ";
  static ElasticLaw elastic(const LineContact& c) {
    return {ElasticLaw::Kind::liu, c.line() / 2, 1.5, c.clearance, 0};
  }
};

}  // namespace freeplay
