// Point contact law F = K δ^(3/2) (1 + χ δ̇/v₀) (contact_law.hpp) with the damping factor
//
//     χ = 3(1 − e)(11 − e)/[2(1 + 9e)]
//
// With this χ, the restitution of a free impact is approximately e: the formula approximates the
// solution χ(e) of the exact equation in contact_law.hpp. Source: A. S. Carvalho, J. M. Martins,
// Exact restitution and generalizations for the Hunt–Crossley contact model, Mech. Mach. Theory 139
// (2019) 174.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::carvalho_martins> : PointLaw {
  static constexpr std::string_view text = "carvalho-martins", formula = "χ = 3(1 − e)(11 − e)/[2(1 + 9e)]",
                                    source = "Carvalho, Martins, Mech. Mach. Theory 139 (2019) 174",
                                    range = "0 ≤ e ≤ 1";
  static double chi(double e) { return 1.5 * (1 - e) * (11 - e) / (1 + 9 * e); }
};

}  // namespace freeplay
