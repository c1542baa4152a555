// Line contact law of a round journal inside a bearing of length L with an elastic layer (law.hpp):
//
//     F = K L R_b [(ΔR + δ)(α + sin α cos α) − 2 ΔR sin α],   cos α = ΔR/(ΔR + δ),
//
// the resultant along the normal of the pressure p = K ⟨(ΔR + δ) cos φ − ΔR⟩ of an elastic foundation
// (Winkler) on the arc of the bearing's radius R_b. The penetration is of first order in ΔR/R_b. K is that of
// a layer of thickness t in plane strain, K = (1 − ν) E_l/[(1 + ν)(1 − 2ν) t].
//
// P. Põdra, S. Andersson, Wear 207 (1997) 79; S. Mukras, N. H. Kim, N. A. Mauntler, T. L. Schmitz,
// W. G. Sawyer, Wear 268 (2010) 643. simulation/bearing_pressure.hpp has the pressure.
#pragma once

#include "formulations/contact/law.hpp"

namespace freeplay {

template <>
struct Law<ContactLaw::elastic_foundation> : LineLaw {
  static constexpr std::string_view text = "elastic-foundation",
                                    formula = "F = KLR_b[(ΔR+δ)(α + sin α cos α) − 2ΔR sin α]",
                                    source = "Põdra, Andersson (1997); Mukras et al. (2010)",
                                    range = "all δ; K of the surface's layer";
  static constexpr bool layered = true;
  static ElasticLaw elastic(const LineContact& c) {
    return {ElasticLaw::Kind::foundation, c.layer * c.length * c.bearing_radius * c.clearance, 1.5,
            c.clearance, 0};
  }
};

}  // namespace freeplay
