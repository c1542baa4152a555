// Speed governor: a torque on a revolute joint with a proportional and an integral term of the
// speed error,
//
//     M = k_p e + k_i z,     e = ω_target(t) − ω,     ż = e,  z(0) = 0.
//
// With a limit, |M| ≤ limit; at the limit z does not grow further beyond it (no wind-up).
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>

#include "mechanism/argument.hpp"
#include "mechanism/curve.hpp"
#include "mechanism/elements/revolute_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Torque that controls the speed of a revolute joint.
struct Governor {
  static constexpr std::string_view what = "a speed governor";
  static constexpr std::array<std::string_view, 1> chosen_by{"target_speed"};
  static constexpr auto reports = ForceElement::Kind::drive;
  std::string name;                  ///< of the element in the scene
  int joint = -1;                    ///< index into Mechanism::joints
  CurveOr target = {};               ///< rad/s
  double proportional = 0;           ///< N m s/rad, ≥ 0
  double integral = 0;               ///< N m/rad, ≥ 0
  std::optional<double> limit = {};  ///< N m, > 0

  static void keys(auto& k, auto& d) {
    k.template joint<RevoluteJoint>({"joint", "", "the revolute joint that is driven"}, d.joint);
    k.number_or_curve(
        {"target_speed", "rad/s", "target speed of a governor, a number or the name of a curve against time"},
        d.target);
    k.take({"proportional", "N m s/rad", "torque per speed error"}, d.proportional, non_negative);
    k.take({"integral", "N m/rad", "torque per integral of the speed error"}, d.integral, non_negative);
    k.take({"torque_limit", "N m", "greatest torque either way; if absent: none"}, d.limit, positive);
    k.check(d.proportional > 0 || d.integral > 0, "", "needs proportional or integral, greater than 0");
  }
  double greatest_effort(const auto& mechanism) const {
    const double most = proportional * pace(mechanism);
    return limit ? std::fmin(*limit, most) : most;
  }
  double pace(const auto& mechanism) const { return target.lay(mechanism.curves).greatest().value; }
};

}  // namespace freeplay
