// Speed governor: a torque on a revolute joint by a proportional and an integral share of what its speed ω lacks,
//
//     M = k_p e + k_i z,     e = ω_target(t) − ω,     ż = e from z = 0,
//
// held within ±limit where one is given; at the limit z does not grow any further into it (no wind-up).
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>

#include "model/argument.hpp"
#include "model/curve.hpp"
#include "model/elements/revolute_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct Governor {
  static constexpr std::string_view what = "a speed governor";
  static constexpr std::array<std::string_view, 1> chosen_by{"target_speed"};
  static constexpr auto reports = ForceElement::Kind::drive;
  std::string name;
  int joint = -1;
  CurveOr target = {};               ///< rad/s
  double proportional = 0;           ///< N m s/rad, ≥ 0
  double integral = 0;               ///< N m/rad, ≥ 0
  std::optional<double> limit = {};  ///< N m, > 0
  Piecewise course = {};             ///< of prepare()

  static void keys(auto& k, auto& d) {
    k.template joint<RevoluteJoint>({"joint", "", "the revolute joint that is driven"}, d.joint);
    k.number_or_curve({"target_speed", "rad/s",
                       "speed that a governor keeps, a number or the name of a curve against time"},
                      d.target);
    k.take({"proportional", "N m s/rad", "torque per lacking speed"}, d.proportional, non_negative);
    k.take({"integral", "N m/rad", "torque per integral of it"}, d.integral, non_negative);
    k.take({"torque_limit", "N m", "greatest torque either way; left out: none"}, d.limit, positive);
    k.check(d.proportional > 0 || d.integral > 0, "", "needs proportional or integral, greater than 0");
  }

  void prepare(const auto& mechanism) { course = target.lay(mechanism.curves); }
  auto link(auto& b) const { return b.joint_link(joint); }
  bool does_work() const { return true; }
  bool needs_velocity() const { return true; }
  bool has_state() const { return integral > 0; }
  /// rad: the angle that is lacking when the integral share is the size of the proportional one.
  double state_scale() const {
    const double speed = course.greatest().value;
    return (speed > 0 ? speed : 1) * (proportional > 0 ? proportional / integral : 1);
  }
  double next_knot(double t) const { return course.next_knot(t); }
  std::optional<CurveReader> reader(const Link& link) const {
    return reader_of(name, course, Argument::time, link);
  }
  double greatest_effort(const auto& mechanism) const {
    const double most = proportional * pace(mechanism);
    return limit ? std::fmin(*limit, most) : most;
  }
  double pace(const auto& mechanism) const { return target.lay(mechanism.curves).greatest().value; }

  template <class T>
  T flow(const auto& m, const auto& link, const T& z) const {
    const T e = lacking<T>(m, link);
    const T torque = proportional * e + integral * z;
    const bool held = limit && (torque > T(*limit) ? e > T(0) : torque < T(-*limit) && e < T(0));
    return held ? T(0) : e;
  }
  template <class T>
  void act(const auto& m, const auto& link, const T* z, auto& out) const {
    T torque = proportional * lacking<T>(m, link);
    if (z) torque += integral * *z;
    if (limit && torque > T(*limit)) torque = *limit;
    if (limit && torque < T(-*limit)) torque = -*limit;
    out.couple(link, torque);
    out.power.drive += torque * m.spin(link);
  }

 private:
  template <class T>
  T lacking(const auto& m, const auto& link) const {
    const T speed = m.spin(link);
    if constexpr (std::is_same_v<T, double>)
      if (const auto* s = m.reading.sweep) return course.mean(m.t - 0.5 * s->h, m.t + 0.5 * s->h) - speed;
    return course.value(m.t) - speed;
  }
};

}  // namespace freeplay
