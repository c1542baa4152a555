// Controllers: a torque on a revolute joint, or a force along a translational joint, that follows
// the error e of the joint's angle or position s with a proportional, an integral and a derivative
// term:
//
//     e = target(t) − s,     u = k_p e + k_d ė + k_i z,     z(0) = 0
//     ż = e − (u − sat u)/(k_i T),     sat u = min(max(u, −limit), limit)
//     τ Ṁ = sat u − M,  M(0) = 0;     without a lag M = sat u
//
// At the limit the difference u − sat u drives the integral back with the tracking time T
// (back-calculation against wind-up: Åström and Hägglund, Advanced PID Control, 2006, sec. 3.5). By
// default T = k_p/k_i, the integral time. s may be that of another joint of the same kind
// (`measured`), for example of the load behind a backlash.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>

#include "mechanism/curve.hpp"
#include "mechanism/elements/revolute_joint.hpp"
#include "mechanism/elements/translational_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Common facts of both kinds of controller; units of an angle, or else of a position.
struct ControlLaw {
  std::string name;                  ///< of the element in the scene
  int joint = -1;                    ///< index into Mechanism::joints
  int measured = -1;                 ///< joint whose angle or position is fed back; −1: `joint`
  CurveOr target = {};               ///< rad or m
  double proportional = 0;           ///< N m/rad or N/m, > 0
  double derivative = 0;             ///< N m s/rad or N s/m, ≥ 0
  double integral = 0;               ///< N m/(rad s) or N/(m s), ≥ 0
  std::optional<double> limit = {};  ///< N m or N, > 0
  std::optional<double> lag = {};    ///< s, > 0; empty: no lag
  /// s, > 0, T of the equations; empty: proportional/integral
  std::optional<double> tracking_time = {};

  /// Units in the order proportional, derivative, integral, limit.
  template <class Joint>
  static void law_keys(auto& k, auto& d, const std::array<std::string_view, 4>& units,
                       std::string_view limit_key) {
    k.template maybe_joint_of<Joint>(
        {"measured", "", "joint whose angle or position is fed back; if absent: the driven joint"},
        d.measured);
    k.need({"proportional", units[0], "torque or force per error"}, d.proportional, positive);
    k.take({"derivative", units[1], "torque or force per rate of the error"}, d.derivative, non_negative);
    k.take({"integral", units[2], "torque or force per integral of the error"}, d.integral, non_negative);
    k.take({limit_key, units[3], "greatest torque or force either way; if absent: none"}, d.limit, positive);
    k.take({"lag", "s", "the torque or force follows with a first-order lag of this time constant, from 0"},
           d.lag, positive);
    if (k.when(d.integral > 0 && d.limit, {"tracking_time"}, "goes with integral and a limit"))
      k.take({"tracking_time", "s",
              "at the limit the integral is driven back within this time; if absent: proportional/integral"},
             d.tracking_time, positive);
  }
  /// The joint that is fed back.
  int fed_back() const { return measured >= 0 ? measured : joint; }
  /// The target as a function of time, rad or m.
  auto course(const auto& mechanism) const { return target.lay(mechanism.curves, Curve::Use::place); }
  /// Greatest torque or force (N m, N) at an error as great as the target.
  double greatest_effort(const auto& mechanism) const {
    const double most = proportional * course(mechanism).greatest().value;
    return limit ? std::fmin(*limit, most) : most;
  }
  /// Greatest rate of the target (rad/s, m/s).
  double greatest_rate(const auto& mechanism) const { return course(mechanism).greatest().slope; }
  /// Time scale (s) of the target's rate; infinite if the rate is constant.
  double change_time(const auto& mechanism) const {
    const auto most = course(mechanism).greatest();
    return most.bend > 0 ? most.slope / most.bend : INFINITY;
  }
};

/// Torque that controls the angle of a revolute joint.
struct AngleController : ControlLaw {
  static constexpr std::string_view what = "an angle controller";
  static constexpr std::array<std::string_view, 1> chosen_by{"target_angle"};
  static constexpr auto reports = ForceElement::Kind::drive;

  static void keys(auto& k, auto& d) {
    k.template joint<RevoluteJoint>({"joint", "", "the revolute joint that is driven"}, d.joint);
    k.number_or_curve(
        {"target_angle", "rad", "target of the angle, a number or the name of a curve against time"},
        d.target, any_number, Curve::Use::place);
    law_keys<RevoluteJoint>(k, d, {"N m/rad", "N m s/rad", "N m/rad s", "N m"}, "torque_limit");
  }
  /// Greatest rate of the target (rad/s).
  double pace(const auto& mechanism) const { return greatest_rate(mechanism); }
};

/// Force that controls the position of a translational joint along its axis.
struct PositionController : ControlLaw {
  static constexpr std::string_view what = "a position controller";
  static constexpr std::array<std::string_view, 1> chosen_by{"target_position"};
  static constexpr auto reports = ForceElement::Kind::push;

  static void keys(auto& k, auto& d) {
    k.template joint<TranslationalJoint>({"joint", "", "the translational joint that is driven"}, d.joint);
    k.number_or_curve({"target_position", "m",
                       "target of the position along the axis, a number or the name of a curve against time"},
                      d.target, any_number, Curve::Use::place);
    law_keys<TranslationalJoint>(k, d, {"N/m", "N s/m", "N/m s", "N"}, "force_limit");
  }
  /// Greatest rate of the target (m/s).
  double slide_pace(const auto& mechanism) const { return greatest_rate(mechanism); }
};

}  // namespace freeplay
