// End stops of what turns: the angle θ = θ_j − θ_i of a revolute joint stays between two limits, each a contact at a radius
// (pairs/angle_stop.hpp). The joint itself may be loose.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include "mechanism/elements/revolute_joint.hpp"
#include "mechanism/elements/travel_stop.hpp"

namespace freeplay {

struct AngleStop {
  static constexpr std::string_view type = "angle-stop", what = "an angle stop";
  std::string name;
  int joint = -1;
  double radius = 0;  ///< m, > 0: of the stop from the joint
  std::optional<double> direction =
      {};          ///< rad, of the stop from the joint in the first body's frame; absent: a couple
  StopFacts stop;  ///< limits in rad

  static void keys(auto& k, auto& c) {
    const auto* on =
        k.template joint<RevoluteJoint>({"joint", "", "the revolute joint whose angle is limited"}, c.joint);
    k.need({"radius", "m", "of the stop from the joint"}, c.radius, positive);
    k.take(
        {"direction", "rad",
         "of the stop from the joint in the first body's frame; left out: stops face to face, a couple without force on "
         "the joint"},
        c.direction, any_number);
    const auto* s = StopFacts::keys(k, c.stop, "rad");
    k.check(
        !on || !on->clearance || !s || !s->friction, "surface",
        "must be one without friction where the joint is loose: how a lever slides on its stop is not modelled");
  }
};

}  // namespace freeplay
