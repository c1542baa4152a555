// Torsional spring and damper: turns its two bodies towards a relative angle φ = θ_j − θ_i with
//
//     M = −stiffness (φ − free_angle) − damping φ̇,     U = ½ stiffness (φ − free_angle)²
//
// spring_law.hpp adds nonconstant rates (a cubic term, preload, tables, one-sided action); M = −F.
#pragma once

#include <array>
#include <string>

#include "mechanism/body.hpp"
#include "mechanism/elements/spring_law.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Torsion spring and damper between two bodies.
struct TorsionalSpringDamper {
  static constexpr std::string_view type = "torsional-spring-damper", what = "a torsional spring-damper";
  static constexpr auto reports = ForceElement::Kind::torque;
  std::string name;                            ///< of the element in the scene
  std::array<int, 2> between{ground, ground};  ///< first and second body: indices, or ground
  double stiffness = 0;                        ///< N m/rad
  double damping = 0;                          ///< N m s/rad
  double free_angle = 0;                       ///< rad, of θ_second − θ_first
  SpringLaw law = {};                          ///< nonconstant part

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    k.pairs({"torque_table", "rad, N m",
             "[[relative angle, torque back], ...] in place of stiffness and free_angle: linear between the "
             "points, extrapolated with the end slopes"},
            l.law.table);
    const bool rates = k.when(l.law.table.empty(), {"stiffness", "free_angle", "cubic", "preload"},
                              "cannot be combined with torque_table");
    if (rates) k.take({"stiffness", "N m/rad", "rate, ≥ 0"}, l.stiffness, non_negative);
    k.pairs({"damping_table", "rad/s, N m",
             "[[relative speed, torque back], ...] in place of damping; has [0, 0]"},
            l.law.damping_table);
    if (k.when(l.law.damping_table.empty(), {"damping"}, "cannot be combined with damping_table"))
      k.take({"damping", "N m s/rad", "damping, ≥ 0"}, l.damping, non_negative);
    if (rates) {
      k.take({"free_angle", "rad", "relative angle without torque"}, l.free_angle);
      k.take({"cubic", "N m/rad³", "times the cube of the angle: hardens, < 0 softens"}, l.law.cubic,
             any_number);
      k.take({"preload", "N m", "torque back at free_angle"}, l.law.preload, any_number);
    }
    k.choose({"one_way", "", "if absent: both ways; "}, l.law.one_way);
    l.law.check(k, "torque_table", "damping_table", l.stiffness);
  }
};

}  // namespace freeplay
