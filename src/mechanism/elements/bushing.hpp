// Bushing: an elastic joint of two bodies. d is the vector from the first body's point to the
// second's; a (along `axis`) and n = perp a are axes of the first body; w = ḋ − ω_i perp d is the
// rate of d in these axes; φ = θ_j − θ_i − free_angle. Then
//
//     F_a = −(k_a a·d + c_a a·w),    F_n = −(k_n n·d + c_n n·w),    M = −(k_φ φ + c_φ φ̇),
//     U = ½ k_a (a·d)² + ½ k_n (n·d)² + ½ k_φ φ²
//
// act on the second body at its point. The opposite force acts on the first body at the same place,
// so that a rotation of the axes needs no energy. The three directions are uncoupled, as in
// Ambrósio and Veríssimo, Multibody System Dynamics 22 (2009) 341. A radial table, isotropic,
// replaces k_a and k_n by F = −f(|d|) d/|d|.
#pragma once

#include <array>
#include <cmath>
#include <string>

#include "mechanism/body.hpp"
#include "mechanism/elements/spring_law.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Elastic connection of two points and of two angles.
struct Bushing {
  static constexpr std::string_view type = "bushing", what = "a bushing";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< m, one point of each body, in its frame
  Vec2 axis{1, 0};                                 ///< unit vector in the first body's frame
  SpringLaw radial = {};                           ///< only its table is used: f against |d|
  Vec2 stiffness{0, 0};                            ///< N/m, along and across the axis
  Vec2 damping{0, 0};                              ///< N s/m, along and across the axis
  double turn_stiffness = 0;                       ///< N m/rad
  double turn_damping = 0;                         ///< N m s/rad
  double free_angle = 0;                           ///< rad, of θ_second − θ_first

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    k.ends("the points that it keeps together", l.at);
    k.axis("first of its two directions, in the first body's frame; the second lies on its left", l.axis);
    k.pairs({"radial_table", "m, N",
             "[[distance, force], ...] from [0, 0], alike in all directions, in place of stiffness"},
            l.radial.table);
    if (k.when(l.radial.table.empty(), {"stiffness"}, "cannot be combined with radial_table"))
      k.take({"stiffness", "N/m", "rates along the axis and across it, ≥ 0"}, l.stiffness);
    k.check(!l.radial.table.empty() || (l.stiffness.x() >= 0 && l.stiffness.y() >= 0), "stiffness",
            "must be two rates of 0 or greater");
    k.take({"damping", "N s/m", "along the axis and across it, ≥ 0"}, l.damping);
    k.check(l.damping.x() >= 0 && l.damping.y() >= 0, "damping", "must be two rates of 0 or greater");
    k.take({"torsional_stiffness", "N m/rad", "rate of the relative angle, ≥ 0"}, l.turn_stiffness,
           non_negative);
    k.take({"torsional_damping", "N m s/rad", "damping of the relative angle, ≥ 0"}, l.turn_damping,
           non_negative);
    k.take({"free_angle", "rad", "relative angle without torque"}, l.free_angle);
    const auto& t = l.radial.table;
    k.check(t.size() != 1, "radial_table", "must have two points or more, has 1");
    k.check(t.empty() || (t.front().first == 0 && t.front().second == 0), "radial_table",
            "must begin at [0, 0]: a bushing at rest has no force");
  }
};

}  // namespace freeplay
