// Contact law of a linear spring and damper:
//
//     F = K δ + D δ̇ ≥ 0
//
// K and D are from the scene. The force jumps at contact onset, and
// the delivered restitution depends on the mass.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::kelvin_voigt> : SpringDamperLaw {
  static constexpr std::string_view text = "kelvin-voigt", formula = "F = Kδ + Dδ̇ ≥ 0",
                                    source = "linear spring and damper",
                                    range = "for comparison only: force jumps at contact onset";
  static ElasticLaw elastic(double stiffness, double clearance) {
    return {ElasticLaw::Kind::linear, stiffness, 1, clearance, 0};
  }
};

}  // namespace freeplay
