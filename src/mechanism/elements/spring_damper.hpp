// Spring and damper between two points at the distance l. It pulls them together with
//
//     F = stiffness (l − free_length) + damping l̇,     U = ½ stiffness (l − free_length)²
//
// along the line through them. If the points coincide, the force has no direction and is zero. A
// motion through that place reverses the direction at once; F then jumps, and the jump is located
// like a kink. spring_law.hpp adds nonconstant rates (a cubic term, preload, tables, one-sided
// action).
#pragma once

#include <array>
#include <cmath>
#include <string>

#include "mechanism/body.hpp"
#include "mechanism/elements/spring_law.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Spring and damper between two points.
struct SpringDamper {
  static constexpr std::string_view type = "spring-damper", what = "a spring-damper";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< m, one point of each body, in its frame
  double stiffness = 0;                            ///< N/m
  double damping = 0;                              ///< N s/m
  double free_length = 0;                          ///< m
  SpringLaw law = {};                              ///< nonconstant part

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    k.ends("its two ends", l.at);
    k.pairs({"force_table", "m, N",
             "[[length, pull], ...] in place of stiffness and free_length: linear between the points, "
             "extrapolated with the end slopes"},
            l.law.table);
    const bool rates = k.when(l.law.table.empty(), {"stiffness", "free_length", "cubic", "preload"},
                              "cannot be combined with force_table");
    if (rates) k.take({"stiffness", "N/m", "rate, ≥ 0"}, l.stiffness, non_negative);
    k.pairs(
        {"damping_table", "m/s, N", "[[speed of lengthening, pull], ...] in place of damping; has [0, 0]"},
        l.law.damping_table);
    if (k.when(l.law.damping_table.empty(), {"damping"}, "cannot be combined with damping_table"))
      k.take({"damping", "N s/m", "damping, ≥ 0"}, l.damping, non_negative);
    if (rates) {
      k.take({"free_length", "m", "length without force"}, l.free_length, non_negative);
      k.take({"cubic", "N/m³", "times the cube of the extension: hardens, < 0 softens"}, l.law.cubic,
             any_number);
      k.take({"preload", "N", "pull at free_length"}, l.law.preload, any_number);
    }
    k.choose({"one_way", "", "if absent: both ways; "}, l.law.one_way);
    l.law.check(k, "force_table", "damping_table", l.stiffness);
  }
};

}  // namespace freeplay
