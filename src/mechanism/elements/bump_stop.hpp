// One-sided springs and dampers: a bump stop of the travel x = a·(r_j − r_i) along an axis a of the
// first body, and one of the angle θ_j − θ_i. At a distance y > 0 beyond a limit they exert a
// restoring force that never pulls,
//
//     F = max(0, stiffness y + damping ẏ),     U = ½ stiffness y²,
//     dissipated power (F − stiffness y) ẏ ≥ 0
//
// The force acts on both bodies through the second one's point.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "mechanism/body.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Common facts of both kinds: limits and force law.
struct Bump {
  std::optional<double> lower = {}, upper = {};  ///< m or rad, at least one of them
  double stiffness = 0;                          ///< N/m or N m/rad
  double damping = 0;                            ///< N s/m or N m s/rad

  static void keys(auto& k, auto& b, std::string_view unit, std::string_view rate, std::string_view speed) {
    k.take({"lower", unit, "the stop acts below this value; if absent: no stop there"}, b.lower, any_number);
    k.take({"upper", unit, "the stop acts above this value; if absent: no stop there"}, b.upper, any_number);
    k.check(b.lower || b.upper, "", "needs lower or upper, or both");
    k.check(!(b.lower && b.upper) || *b.lower < *b.upper, "upper", "must be greater than lower");
    k.take({"stiffness", rate, "rate, ≥ 0"}, b.stiffness, non_negative);
    k.take({"damping", speed, "damping, ≥ 0"}, b.damping, non_negative);
  }
};

/// One-sided spring and damper against the travel along an axis.
struct BumpStop {
  static constexpr std::string_view type = "bump-stop", what = "a bump stop";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< m, one point of each body, in its frame
  Vec2 axis{1, 0};                                 ///< unit vector in the first body's frame
  Bump bump;                                       ///< limits in m

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    k.ends("its two ends", l.at);
    k.axis("direction of the travel in the first body's frame", l.axis);
    Bump::keys(k, l.bump, "m", "N/m", "N s/m");
  }
};

/// One-sided torsion spring and damper against the relative angle.
struct TorsionalBumpStop {
  static constexpr std::string_view type = "torsional-bump-stop", what = "a torsional bump stop";
  static constexpr auto reports = ForceElement::Kind::torque;
  std::string name;                            ///< of the element in the scene
  std::array<int, 2> between{ground, ground};  ///< first and second body: indices, or ground
  Bump bump;                                   ///< limits in rad, of θ_second − θ_first

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    Bump::keys(k, l.bump, "rad", "N m/rad", "N m s/rad");
  }
};

}  // namespace freeplay
