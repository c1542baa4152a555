// End stops of a revolute joint: the angle θ = θ_j − θ_i stays between two limits. Each limit is a
// contact at a distance `radius` from the joint (dynamics/pairs.hpp). The joint may have
// clearance.
//
// A stop without direction acts by a couple M = ± r F alone. For a rigid stop, M and the impulse do not
// depend on r. The default r = 1 m makes forces (N) moments (N m) of the same number, approach speeds angular
// velocities, and a stiffness in N/m one in N m/rad. Hertz's stiffness acts at a place and requires r.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "mechanism/elements/revolute_joint.hpp"
#include "mechanism/elements/travel_stop.hpp"

namespace freeplay {

/// End stops of a revolute joint.
struct AngleStop {
  static constexpr std::string_view type = "angle-stop", what = "an angle stop";
  std::string name;                   ///< of the element in the scene
  int joint = -1;                     ///< index into Mechanism::joints
  std::optional<double> radius = {};  ///< m, > 0, distance of the stop from the joint; empty: 1 m
  /// rad, of the stop from the joint, in the first body's frame; empty: a couple
  std::optional<double> direction = {};
  StopFacts stop;  ///< limits in rad

  static void keys(auto& k, auto& c) {
    const auto* on =
        k.template joint<RevoluteJoint>({"joint", "", "the revolute joint whose angle is limited"}, c.joint);
    k.take({"radius", "m",
            "of the stop from the joint; required with direction and with curvature_radius; if absent: 1 m, "
            "so that forces in N are moments in N m and a stiffness in N/m is one in N m/rad"},
           c.radius, positive);
    k.take({"direction", "rad",
            "of the stop from the joint in the first body's frame; if absent: stops face to face, a couple "
            "without force on the joint"},
           c.direction, any_number);
    k.check(c.radius || !c.direction, "radius", "is required with direction: the stop acts at this distance");
    const auto* s = StopFacts::keys(k, c.stop, "rad");
    k.check(c.radius || !c.stop.curvature_radius, "radius",
            "is required with curvature_radius: Hertz's stiffness acts at this distance");
    k.check(!on || !on->clearance || !s || !s->friction, "surface",
            "must be without friction if the joint has clearance: sliding of a lever on its stop is not "
            "modelled");
  }

  /// m, arm of the stop's force.
  double arm() const { return radius.value_or(1); }
};

}  // namespace freeplay
