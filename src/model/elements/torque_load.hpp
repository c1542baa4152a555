// Torque on a body; a curve may scale it: M(x) = torque·factor(x).
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "model/argument.hpp"
#include "model/body.hpp"
#include "model/curve.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct TorqueLoad {
  static constexpr std::string_view type = "torque", what = "a torque";
  static constexpr auto reports = ForceElement::Kind::torque;
  std::string name;
  int body = ground;
  double torque = 0;  ///< N m
  int factor = -1;    ///< index into Mechanism::curves, −1: the torque is constant
  Argument against = Argument::time;
  OtherJoint other = {};
  Piecewise course = {};  ///< of prepare()

  static void keys(auto& k, auto& l) {
    k.body({"body", "", "the loaded body"}, l.body);
    k.need({"torque", "N m", "the torque, or what `factor` scales"}, l.torque, any_number);
    k.maybe_curve({"factor", "", "name of a curve that scales it; left out: constant"}, l.factor);
    if (k.when(l.factor >= 0, {"against"}, "goes with factor"))
      k.choose({"against", "", "what the factor is read against: "}, l.against);
    k.check(l.against != Argument::position, "against", "a torque has an angle, no position");
    OtherJoint::keys(k, l.other, l.against, l.factor >= 0);
  }

  void prepare(const auto& mechanism) {
    if (factor >= 0) course = mechanism.curves[factor].lay();
  }
  auto link(auto& b) const { return b.free_link({ground, body}, {}); }
  bool does_work() const { return true; }
  bool needs_velocity() const { return factor >= 0 && against != Argument::time; }
  double next_knot(double t) const {
    return factor >= 0 && against == Argument::time ? course.next_knot(t) : INFINITY;
  }
  std::optional<Phase> phase(const Link& link) const {
    return factor < 0 ? std::nullopt : phase_of(course, against, other.or_own(link));
  }
  std::optional<CurveReader> reader(const Link& link) const {
    if (factor < 0) return {};
    return reader_of(name, course, against, other.or_own(link));
  }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    T M = torque;
    if (factor >= 0) {
      const Link& read = other.or_own(link);
      M *= read_at<T>(course, against, m, m.angle(read),
                      [&](const T* v) { return omega(v, read.j) - omega(v, read.i); });
    }
    out.couple(link, M);
    out.power.load += M * m.spin(link);
  }
};

}  // namespace freeplay
