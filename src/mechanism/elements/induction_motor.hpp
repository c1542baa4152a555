// Asynchronous motor on a revolute joint by Kloss's quasi-stationary formula. With the slip
// s = (ω_s − ω)/ω_s of the second body's speed ω relative to the first:
//
//     M = 2 M_k/(s/s_k + s_k/s) = 2 M_k s s_k/(s² + s_k²)      in the sense of ω_s
//
// (M. Kloss, Arch. Elektrotech. 5 (1916) 59.) Beyond ω_s it brakes.
#pragma once

#include <array>
#include <cmath>
#include <string>

#include "mechanism/elements/speed_drive.hpp"

namespace freeplay {

/// Induction motor on a revolute joint.
struct InductionMotor {
  static constexpr std::string_view what = "an asynchronous motor";
  static constexpr std::array<std::string_view, 1> chosen_by{"breakdown_torque"};
  static constexpr auto reports = ForceElement::Kind::drive;
  std::string name;              ///< of the element in the scene
  int joint = -1;                ///< index into Mechanism::joints
  double breakdown_torque = 0;   ///< N m, > 0
  double breakdown_slip = 0;     ///< > 0
  double synchronous_speed = 0;  ///< rad/s, nonzero; its sign is the sense of rotation

  static void keys(auto& k, auto& d) {
    k.template joint<RevoluteJoint>({"joint", "", "the revolute joint that is driven"}, d.joint);
    k.need({"breakdown_torque", "N m", "greatest torque M_k of an asynchronous motor"}, d.breakdown_torque,
           positive);
    k.need({"breakdown_slip", "", "slip s_k at which it has it"}, d.breakdown_slip, positive);
    k.either({"synchronous_speed_rpm", "rpm", "speed of its field"}, any_number, SpeedDrive::from_rpm,
             {"synchronous_speed", "rad/s", "the same in rad/s; or synchronous_speed_rpm"}, any_number,
             d.synchronous_speed);
    k.check(d.synchronous_speed != 0, "", "the synchronous speed must not be 0");
  }
  double greatest_effort(const auto&) const { return breakdown_torque; }
  double pace(const auto&) const { return std::abs(synchronous_speed); }
};

}  // namespace freeplay
