// Dynamics of mechanism/elements/governor.hpp, which states the equations.
#pragma once

#include "dynamics/argument.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/elements/governor.hpp"
#include "mechanism/piecewise.hpp"
#include "numerics/choice.hpp"

namespace freeplay {

template <>
struct Dynamics<Governor> : Governor {
  Piecewise course = {};  ///< set by prepare()

  void prepare(const auto& mechanism) { course = target.lay(mechanism.curves); }
  auto link(auto& b) const { return b.joint_link(joint); }
  bool does_work() const { return true; }
  bool needs_velocity() const { return true; }
  bool has_state() const { return integral > 0; }
  /// Scale of the state (rad): its value if the integral and the proportional term are equal.
  double state_scale() const {
    const double speed = course.greatest().value;
    return (speed > 0 ? speed : 1) * (proportional > 0 ? proportional / integral : 1);
  }
  double next_knot(double t) const { return course.next_knot(t); }
  std::optional<CurveReader> reader(const Link& link) const {
    return reader_of(name, course, Argument::time, link);
  }

  int limiters() const { return limit.has_value(); }
  Saturation saturation(const auto& m, const Link& link, const double* z) const {
    const double own = z ? integral * *z : 0, target = course.value(m.t), speed = m.spin(link);
    return {(proportional * (target - speed) + own) / *limit,
            (proportional * (std::abs(target) + std::abs(speed)) + std::abs(own)) / *limit};
  }

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
    if (limit) torque = limited(torque, *limit);
    out.couple(link, torque);
    out.power.drive += torque * m.spin(link);
  }

 private:
  template <class T>
  T lacking(const auto& m, const auto& link) const {
    const T speed = m.spin(link);
    if (const auto* s = m.reading.sweep) return course.mean(m.t - 0.5 * s->h, m.t + 0.5 * s->h) - speed;
    return course.value(m.t) - speed;
  }
};

}  // namespace freeplay
