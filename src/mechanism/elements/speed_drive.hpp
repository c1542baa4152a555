// Prescribed relative speed of a joint's two bodies, one row:
//
//     θ_second − θ_first = initial_angle + speed·t
#pragma once

#include <array>
#include <numbers>
#include <string>

#include "mechanism/elements/revolute_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Drive of a revolute joint with constant speed.
struct SpeedDrive {
  static constexpr std::string_view what = "a speed drive";
  static constexpr std::array<std::string_view, 2> chosen_by{"speed_rpm", "speed"};
  static constexpr auto reports = ForceElement::Kind::drive;
  std::string name;          ///< of the element in the scene
  int joint = -1;            ///< index into Mechanism::joints
  double speed = 0;          ///< rad/s
  double initial_angle = 0;  ///< rad, at t = 0
  /// Marks the joint whose revolutions are counted, regardless of the order of drives.
  bool crank = false;

  /// rad/s, from revolutions per minute
  static double from_rpm(double rpm) { return rpm * 2 * std::numbers::pi / 60; }

  static void keys(auto& k, auto& d) {
    k.template joint<RevoluteJoint>(
        {"joint", "", "the revolute joint that is driven (translational: none yet)"}, d.joint);
    k.either({"speed_rpm", "rpm", "prescribed speed of the second body relative to the first"}, any_number,
             from_rpm, {"speed", "rad/s", "the same in rad/s; or speed_rpm"}, any_number, d.speed);
    k.joint_angle({"initial_angle", "rad",
                   "relative angle at t = 0; default: that of the bodies' `angle` keys", "from the bodies"},
                  d.initial_angle, d.joint);
    k.take({"crank", "",
            "the revolutions of this drive are counted (crank_angle, revolutions); default: those of the "
            "first drive of prescribed speed"},
           d.crank);
  }
};

}  // namespace freeplay
