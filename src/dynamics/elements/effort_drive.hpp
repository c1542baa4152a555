// Dynamics of mechanism/elements/effort_drive.hpp, which states the equations.
#pragma once

#include "dynamics/argument.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/elements/effort_drive.hpp"
#include "mechanism/piecewise.hpp"

namespace freeplay {

template <>
struct Dynamics<TorqueCurveDrive> : CurveDynamics<TorqueCurveDrive> {
  void prepare(const auto& mechanism) { course = mechanism.curves[curve].lay(); }
  auto link(auto& b) const { return b.joint_link(joint); }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const T torque = read_turning<T>(m, link);
    out.couple(link, torque);
    out.power.drive += torque * m.spin(link);
  }
};

template <>
struct Dynamics<ForceDrive> : CurveDynamics<ForceDrive> {
  Vec2 axis{1, 0};  ///< set by prepare()

  void prepare(const auto& mechanism) {
    course = force.lay(mechanism.curves);
    axis = std::get<TranslationalJoint>(mechanism.joints[joint]).axis;
  }
  auto link(auto& b) const { return b.joint_link(joint); }
  std::optional<Phase> phase(const Link& link) const {
    return phase_of(course, against, read.or_own(link), other.of >= 0 ? nullptr : &axis);
  }
  std::optional<CurveReader> reader(const Link& link) const {
    return reader_of(name, course, against, read.or_own(link), other.of >= 0 ? nullptr : &axis);
  }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const AlongAxis<T> on(link, axis, m.q, m.e);
    const T push = other.of >= 0 ? read_at_angle<T>(course, m, read.link)
                                 : read_at<T>(course, against, m, on.place,
                                              [&](const T* v) { return on.rate(link, v); });
    out.pull(link, on.arms, Vec2Of<T>{push * on.axis.x(), push * on.axis.y()});
    out.power.drive += push * on.rate(link, m.v);
  }
};

}  // namespace freeplay
