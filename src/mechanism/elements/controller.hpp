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
//
// With a sampling time h the controller is a discrete one (Åström and Wittenmark, Computer-Controlled
// Systems, 3rd ed., 1997, sec. 8.5; Åström and Hägglund, ch. 13). At the instants t_k = k h, from the
// start of the motion on,
//
//     e_k = target(t_k) − r round(s(t_k)/r);     without a resolution r: target(t_k) − s(t_k)
//     u_k = k_p e_k + k_d (e_k − e_{k−1})/h + k_i z_k,     z = 0 and e_{k−1} = e_k at the first instant
//     z_{k+1} = z_k + h e_k − h (u_k − sat u_k)/(k_i T)
//
// sat u_k takes the place of sat u above from t_k + dead time on, until the next output does: a
// zero-order hold. It is 0 before the first output. (docs/theory/event-location.md)
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

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
  std::optional<double> sampling_time = {};  ///< s, > 0, h of the equations; empty: continuous
  double dead_time = 0;                      ///< s, ≥ 0, at most most_delay sampling times
  std::optional<double> resolution = {};     ///< rad or m, > 0; empty: exact

  /// Greatest dead time in sampling times.
  static constexpr double most_delay = 100;

  /// Units in the order proportional, derivative, integral, limit, resolution.
  template <class Joint>
  static void law_keys(auto& k, auto& d, const std::array<std::string_view, 5>& units,
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
    k.take({"sampling_time", "s",
            "the output is computed at whole multiples of this time and held between; if absent: continuous"},
           d.sampling_time, positive);
    if (k.when(d.sampling_time.has_value(), {"dead_time", "resolution"}, "goes with sampling_time")) {
      k.take({"dead_time", "s",
              "from a sample to the instant from which its output acts, at most 100 sampling times"},
             d.dead_time, non_negative);
      k.take({"resolution", units[4],
              "the measured coordinate is rounded to multiples of this, as by an encoder; if absent: exact"},
             d.resolution, positive);
    }
    if (!d.sampling_time) return;
    k.check(d.dead_time <= most_delay * *d.sampling_time * (1 + 1e-9), "dead_time", "must be at most ",
            most_delay, " sampling times, ", most_delay * *d.sampling_time, " s, is ", d.dead_time);
    if (d.integral > 0 && d.limit)
      k.check(*d.sampling_time <= d.tracking(), "sampling_time", "must be at most the tracking time, ",
              d.tracking(), " s: the limit would drive the integral too far back");
  }
  /// T of the equations.
  double tracking() const { return tracking_time.value_or(proportional / integral); }
  /// The dead time as whole samples and a rest below one sample (s); needs a sampling time.
  std::pair<int, double> delay() const {
    const double h = *sampling_time, samples = dead_time / h, whole = std::round(samples);
    if (std::abs(samples - whole) <= 1e-9 * std::max(1.0, samples)) return {static_cast<int>(whole), 0};
    return {static_cast<int>(samples), dead_time - static_cast<int>(samples) * h};
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
    law_keys<RevoluteJoint>(k, d, {"N m/rad", "N m s/rad", "N m/rad s", "N m", "rad"}, "torque_limit");
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
    law_keys<TranslationalJoint>(k, d, {"N/m", "N s/m", "N/m s", "N", "m"}, "force_limit");
  }
  /// Greatest rate of the target (m/s).
  double slide_pace(const auto& mechanism) const { return greatest_rate(mechanism); }
};

}  // namespace freeplay
