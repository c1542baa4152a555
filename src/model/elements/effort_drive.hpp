// Torque of a revolute joint or force along the axis of a translational one, on the second body and its opposite on the
// first, by a curve against time, the joint's angle or place, its speed, or the angle of another joint; both power the drive: M (ω_j − ω_i), F ṡ.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <type_traits>

#include "model/argument.hpp"
#include "model/curve.hpp"
#include "model/elements/revolute_joint.hpp"
#include "model/elements/translational_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct TorqueCurveDrive {
  static constexpr std::string_view what = "a torque curve drive";
  static constexpr std::array<std::string_view, 1> chosen_by{"torque_curve"};
  static constexpr auto reports = ForceElement::Kind::drive;
  std::string name;
  int joint = -1;
  int curve = -1;  ///< index into Mechanism::curves
  Argument against = Argument::time;
  OtherJoint other = {};
  Piecewise course = {};  ///< of prepare()

  static void keys(auto& k, auto& d) {
    k.template joint<RevoluteJoint>({"joint", "", "the revolute joint that is driven"}, d.joint);
    k.curve({"torque_curve", "N m", "name of the curve of the torque on the second body"}, d.curve);
    k.choose({"against", "", "what the curve is read against: "}, d.against);
    k.check(d.against != Argument::position, "against", "a revolute joint has an angle, no position");
    OtherJoint::keys(k, d.other, d.against, true);
  }

  void prepare(const auto& mechanism) { course = mechanism.curves[curve].lay(); }
  auto link(auto& b) const { return b.joint_link(joint); }
  bool does_work() const { return true; }
  bool needs_velocity() const { return against != Argument::time; }
  double next_knot(double t) const { return against == Argument::time ? course.next_knot(t) : INFINITY; }
  std::optional<Phase> phase(const Link& link) const { return phase_of(course, against, other.or_own(link)); }
  std::optional<CurveReader> reader(const Link& link) const {
    return reader_of(name, course, against, other.or_own(link));
  }
  double greatest_effort(const auto& mechanism) const {
    return mechanism.curves[curve].lay().greatest().value;
  }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const Link& read = other.or_own(link);
    const T torque = read_at<T>(course, against, m, m.angle(read),
                                [&](const T* v) { return omega(v, read.j) - omega(v, read.i); });
    out.couple(link, torque);
    out.power.drive += torque * m.spin(link);
  }
};

struct ForceDrive {
  static constexpr std::string_view what = "a force drive";
  static constexpr std::array<std::string_view, 1> chosen_by{"force"};
  static constexpr auto reports = ForceElement::Kind::push;
  std::string name;
  int joint = -1;
  CurveOr force = {};
  Argument against = Argument::time;
  OtherJoint other = {};
  Piecewise course = {};  ///< of prepare(), as the axis
  Vec2 axis{1, 0};

  static void keys(auto& k, auto& d) {
    k.template joint<TranslationalJoint>({"joint", "", "the translational joint that is driven"}, d.joint);
    k.number_or_curve(
        {"force", "N", "along its axis on the second body, its opposite on the first; a number or a curve"},
        d.force);
    if (k.when(d.force.curve >= 0, {"against"}, "goes with a curve"))
      k.choose({"against", "", "what the curve is read against: "}, d.against);
    OtherJoint::keys(k, d.other, d.against, d.force.curve >= 0);
    k.check(
        d.against != Argument::angle || d.other.of >= 0, "against",
        "a translational joint has a position, no angle; `of` names a revolute joint whose angle is meant");
  }

  void prepare(const auto& mechanism) {
    course = force.lay(mechanism.curves);
    axis = std::get<TranslationalJoint>(mechanism.joints[joint]).axis;
  }
  auto link(auto& b) const {
    const auto& on = std::get<TranslationalJoint>(b.mechanism().joints[joint]);
    return b.free_link(on.between, on.at);
  }
  bool does_work() const { return true; }
  bool needs_velocity() const { return against != Argument::time; }
  double next_knot(double t) const { return against == Argument::time ? course.next_knot(t) : INFINITY; }
  std::optional<Phase> phase(const Link& link) const {
    return phase_of(course, against, other.or_own(link), other.of >= 0 ? nullptr : &axis);
  }
  std::optional<CurveReader> reader(const Link& link) const {
    return reader_of(name, course, against, other.or_own(link), other.of >= 0 ? nullptr : &axis);
  }
  double greatest_effort(const auto& mechanism) const { return force.lay(mechanism.curves).greatest().value; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const AlongAxis<T> on(link, axis, m.q, m.e);
    const T push = other.of >= 0 ? read_at_angle<T>(course, m, other.link)
                                 : read_at<T>(course, against, m, on.place,
                                              [&](const T* v) { return on.rate(link, v); });
    out.pull(link, on.arms, Vec2Of<T>{push * on.axis.x(), push * on.axis.y()});
    out.power.drive += push * on.rate(link, m.v);
  }
};

}  // namespace freeplay
