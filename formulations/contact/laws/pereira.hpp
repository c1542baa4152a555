// Line contact law of a journal inside a bearing of length L (law.hpp):
//
//     F = [(0.965ΔR + 0.0965) L E*/ΔR] δⁿ,   n = Y ΔR^(−0.005),   lengths in mm, F in N, E* in MPa,
//
//     Y = 1.51 [ln(1000 ΔR)]^(−0.151)   for 0.005 ≤ ΔR < 0.34954,
//     Y = 0.0151 ΔR + 1.151             for 0.34954 ≤ ΔR < 10,
//
// with the damping factor of Lankarani and Nikravesh.
// C. M. Pereira, A. L. Ramalho, J. A. Ambrósio, A critical overview of internal and external
// cylinder contact force models, Nonlinear Dyn. 63 (2011) 681.
#pragma once

#include <cmath>

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::pereira> : LineLaw {
  static constexpr std::string_view text = "pereira", formula = "F = [(0.965ΔR + 0.0965)LE*/ΔR] δⁿ (mm, N)",
                                    source = "Pereira, Ramalho, Ambrósio (2011)",
                                    range = "0.005 mm ≤ ΔR < 10 mm";
  static constexpr std::optional<ContactLaw> damping = ContactLaw::lankarani_nikravesh;
  static constexpr double least_clearance = 0.005e-3, clearance_end = 10e-3;

  static double exponent(double mm) {
    const double Y = mm < 0.34954 ? 1.51 * std::pow(std::log(1000 * mm), -0.151) : 0.0151 * mm + 1.151;
    return Y * std::pow(mm, -0.005);
  }
  static ElasticLaw elastic(const LineContact& c) {
    // K (N/mmⁿ) · (1000 δ)ⁿ
    const double mm = 1e3 * c.clearance, n = exponent(mm);
    const double K = (0.965 * mm + 0.0965) * (1e3 * c.length) * (1e-6 * c.modulus) / mm;
    return {ElasticLaw::Kind::power, K * std::pow(1e3, n), n, c.clearance, 0};
  }
};

}  // namespace freeplay
