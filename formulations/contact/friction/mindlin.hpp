// Tangential compliance with slip: a tangential spring in series with Coulomb friction
// (friction_law.hpp). Without partial slip the whole contact area sticks or slides. This file has
// the facts of the law, and its coefficient in steady sliding, c = μ.
// Sources: R. D. Mindlin, H. Deresiewicz, Elastic spheres in contact under varying oblique forces,
// J. Appl. Mech. 20 (1953) 327 (stiffness); N. Maw, J. R. Barber, J. N. Fawcett, The oblique impact
// of elastic spheres, Wear 38 (1976) 101 (impacts).
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<FrictionLaw::mindlin> : AnyFrictionLaw {
  static constexpr std::string_view
      text = "mindlin",
      formula =
          "−F_T/F_N of a tangential spring of stiffness κ F_el'(δ), which slips "
          "at μ",
      source = "Mindlin and Deresiewicz, J. Appl. Mech. 20 (1953) 327",
      range = "point contacts; sticks elastically, no partial slip", keys{};
  static constexpr bool kink_at_rest = true, compliant = true;
  template <class T>
  static T coefficient(const FrictionParameters& p, const T&, int) {
    return T(p.mu);
  }
};

}  // namespace freeplay
