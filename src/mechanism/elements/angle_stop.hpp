// End stops of a revolute joint: the angle θ = θ_j − θ_i stays between two limits. Each limit is a
// contact at a distance `radius` from the joint (dynamics/pairs.hpp). The joint may have
// clearance.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include "mechanism/elements/revolute_joint.hpp"
#include "mechanism/elements/travel_stop.hpp"

namespace freeplay {

/// End stops of a revolute joint.
struct AngleStop {
  static constexpr std::string_view type = "angle-stop", what = "an angle stop";
  std::string name;   ///< of the element in the scene
  int joint = -1;     ///< index into Mechanism::joints
  double radius = 0;  ///< m, > 0, distance of the stop from the joint
  /// rad, of the stop from the joint, in the first body's frame; empty: a couple
  std::optional<double> direction = {};
  StopFacts stop;  ///< limits in rad

  static void keys(auto& k, auto& c) {
    const auto* on =
        k.template joint<RevoluteJoint>({"joint", "", "the revolute joint whose angle is limited"}, c.joint);
    k.need({"radius", "m", "of the stop from the joint"}, c.radius, positive);
    k.take({"direction", "rad",
            "of the stop from the joint in the first body's frame; if absent: stops face to face, a couple "
            "without force on the joint"},
           c.direction, any_number);
    const auto* s = StopFacts::keys(k, c.stop, "rad");
    k.check(!on || !on->clearance || !s || !s->friction, "surface",
            "must be without friction if the joint has clearance: sliding of a lever on its stop is not "
            "modelled");
  }
};

}  // namespace freeplay
