// DC motor with permanent magnets on a revolute joint; ω is the speed of the second body relative
// to the first:
//
//     L di/dt = U(t) − R i − k_e ω,  i(0) = 0,     M = k_t i
//     without inductance: i = (U − k_e ω)/R
//
// Stall torque M = k_t U/R; no-load speed ω = U/k_e. (Leonhard, Control of Electrical Drives, ch.
// 5)
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

/// DC motor on a revolute joint.
struct DcMotor {
  static constexpr std::string_view what = "a DC motor";
  static constexpr std::array<std::string_view, 1> chosen_by{"voltage"};
  static constexpr auto reports = ForceElement::Kind::drive;
  std::string name;                         ///< of the element in the scene
  int joint = -1;                           ///< index into Mechanism::joints
  CurveOr voltage = {};                     ///< V
  double resistance = 0;                    ///< Ω, > 0
  double torque_constant = 0;               ///< N m/A, > 0
  std::optional<double> emf_constant = {};  ///< V s/rad, > 0; empty: equal to the torque constant
  /// H, > 0; empty: the current follows the voltage without delay
  std::optional<double> inductance = {};

  static void keys(auto& k, auto& d) {
    k.template joint<RevoluteJoint>({"joint", "", "the revolute joint that is driven"}, d.joint);
    k.number_or_curve({"voltage", "V", "supply of a DC motor, a number or the name of a curve against time"},
                      d.voltage);
    k.need({"resistance", "ohm", "of the armature"}, d.resistance, positive);
    k.need({"torque_constant", "N m/A", "torque per current"}, d.torque_constant, positive);
    k.take({"emf_constant", "V s/rad", "induced voltage per speed; if absent: the torque constant"},
           d.emf_constant, positive);
    k.take({"inductance", "H", "of the armature; if absent: none, the current follows at once"}, d.inductance,
           positive);
  }
  double greatest_effort(const auto& mechanism) const {
    return torque_constant / resistance * voltage.lay(mechanism.curves).greatest().value;
  }
  double pace(const auto& mechanism) const {
    return voltage.lay(mechanism.curves).greatest().value / emf_constant.value_or(torque_constant);
  }
};

}  // namespace freeplay
