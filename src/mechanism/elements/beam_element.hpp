// Beam element: a piece of a planar beam between two bodies. Its ends are the points P_i, P_j, its tangents there the
// directions ψ = θ + angle; β and L are the direction and the length of d = P_j − P_i. With φ = ψ − β at both ends, in
// (−π, π), l the unloaded length and φ⁰ = ∓κ₀ l/2 at the first and second end for the unloaded curvature κ₀,
//
//     e = L − l + l (2φ_i² − φ_i φ_j + 2φ_j²)/30,      a = φ_i − φ_i⁰,      b = φ_j − φ_j⁰,
//     U = ½ EA/l e² + EI/(2 l (1 + Φ)) ((4 + Φ)(a² + b²) + 2 (2 − Φ) a b),      Φ = 12 EI/(κGA l²),
//
// and damping τ adds τ ė, τ ȧ, τ ḃ to e, a, b in the forces. The deflection over the chord is a cubic; e contains
// the elongation by its slope, averaged over the length, so the element has no membrane locking and buckles. Rotations
// of the chord may be large; φ must be small, so that the number of elements determines the accuracy. Corotational
// form: Crisfield, Non-linear Finite Element Analysis of Solids and Structures 1 (1991), ch. 7; shear: Przemieniecki,
// Theory of Matrix Structural Analysis (1968), section 5.6.
#pragma once

#include <array>
#include <string>

#include "mechanism/body.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// An elastic piece between two bodies, without mass.
struct BeamElement {
  static constexpr std::string_view type = "beam", what = "a beam element";
  static constexpr auto reports = ForceElement::Kind::section;
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< m, its end on each body, in the body's frame
  Vec2 angles{0, 0};                               ///< rad, of its tangents in the frames of the bodies
  double length = 0;                               ///< m, unloaded, along the beam
  double axial = 0;                                ///< N, EA
  double bending = 0;                              ///< N m², EI
  double shear = 0;                                ///< N, κGA; 0: rigid in shear
  double curvature = 0;                            ///< 1/m, unloaded; positive to the left
  double damping = 0;                              ///< s, τ: stiffness-proportional
  double section = 0;  ///< place of the reported section from the middle, over the length: −½ to ½
  bool made = false;   ///< made from a beam, which states all its facts

  static void keys(auto& k, auto& x) {
    k.between("two bodies, or \"ground\" and a body", x.between);
    k.ends("the ends of the beam", x.at);
    k.take({"angles", "rad",
            "of the beam's tangent from its first to its second end, in the frame of each body"},
           x.angles);
    k.need({"length", "m", "unloaded, along the beam, > 0"}, x.length, positive);
    k.need({"axial_stiffness", "N", "Young's modulus times area, > 0"}, x.axial, positive);
    k.need({"bending_stiffness", "N m²", "Young's modulus times second moment of area, > 0"}, x.bending,
           positive);
    k.take({"shear_stiffness", "N", "shear modulus times shear area", "rigid in shear"}, x.shear,
           non_negative);
    k.take({"curvature", "1/m", "of the unloaded beam, positive if it bends to the left"}, x.curvature);
    k.take({"damping_time", "s", "stiffness-proportional: the factor of the strain rates, ≥ 0"}, x.damping,
           non_negative);
  }
};

}  // namespace freeplay
