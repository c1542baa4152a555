// Force F on a point of a body, in the world's directions or in the body's own; its power is F·v_P. A curve may scale it:
// F(x) = force·factor(x). In memory a function from outside may stand in its place (model/own_force.hpp).
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "model/argument.hpp"
#include "model/body.hpp"
#include "model/curve.hpp"
#include "model/own_force.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct ForceLoad {
  enum class Axes { world, body };
  static constexpr std::string_view type = "force", what = "a force";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;
  int body = ground;
  Vec2 at{0, 0};     ///< m, in the body's frame
  Vec2 force{0, 0};  ///< N
  Axes axes = Axes::world;
  int factor = -1;  ///< index into Mechanism::curves, −1: the force is constant
  Argument against = Argument::time;
  OtherJoint other = {};
  std::shared_ptr<const OwnForce> own = {};  ///< in place of force and factor; no key
  Piecewise course = {};                     ///< of prepare()

  static void keys(auto& k, auto& l) {
    k.body({"body", "", "the loaded body"}, l.body);
    k.point_of({"at", "m", "the loaded point in the body's frame"}, l.body, l.at);
    k.need({"force", "N", "the force, or what `factor` scales"}, l.force);
    k.choose_other({"axes", "", "directions of the force: "}, l.axes);
    k.maybe_curve({"factor", "", "name of a curve that scales it; left out: constant"}, l.factor);
    if (k.when(l.factor >= 0, {"against"}, "goes with factor"))
      k.choose({"against", "", "what the factor is read against: "}, l.against);
    OtherJoint::keys(k, l.other, l.against, l.factor >= 0);
    k.check(l.axes == Axes::world || l.against != Argument::position, "against",
            "a force in the body's own directions has no direction in the world to take a position along");
    k.check(l.factor < 0 || !l.force.is_zero(), "force", "must not be zero where a factor scales it");
  }

  void prepare(const auto& mechanism) {
    if (factor >= 0) course = mechanism.curves[factor].lay();
  }
  auto link(auto& b) const { return b.free_link({ground, body}, {Vec2{0, 0}, at}); }
  bool does_work() const { return true; }
  bool needs_velocity() const { return own || (factor >= 0 && against != Argument::time); }
  double next_knot(double t) const {
    return !own && factor >= 0 && against == Argument::time ? course.next_knot(t) : INFINITY;
  }
  std::optional<Phase> phase(const Link& link) const {
    const Vec2 along = force.is_zero() ? force : force.direction();
    return own || factor < 0 ? std::nullopt
                             : phase_of(course, against, other.or_own(link),
                                        against == Argument::position ? &along : nullptr);
  }
  std::optional<CurveReader> reader(const Link& link) const {
    if (own || factor < 0) return {};
    const Vec2 along = force.is_zero() ? force : force.direction();
    return reader_of(name, course, against, other.or_own(link),
                     against == Argument::angle ? nullptr : &along);
  }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const auto a = m.arms(link);
    Vec2Of<T> f{T(force.x()), T(force.y())};
    if (own) f = from_outside<T>(m, link, a);
    if (!own && axes == Axes::body) f = turned(link.j, force, m.e);
    if (!own && factor >= 0) f = scaled<T>(m, link, a, f);
    out.pull(link, a, f);
    out.power.load += dot(f, m.relative_velocity(link, a));
  }

 private:
  template <class T>
  Vec2Of<T> scaled(const auto& m, const auto& link, const Arms<T>& a, const Vec2Of<T>& f) const {
    const auto moves = [&](const T* v) { return dot(f, relative_velocity(link, a, v)) / force.norm(); };
    const T s = against == Argument::angle
                    ? read_at_angle<T>(course, m, other.or_own(link))
                    : read_at<T>(course, against, m, dot(f, a.d) / force.norm(), moves);
    return {s * f.x(), s * f.y()};
  }
  template <class T>
  Vec2Of<T> from_outside(const auto& m, const auto& link, const Arms<T>& a) const {
    const Vec2Of<T> still{T(0), T(0)};
    const Vec2Of<T> f = own->at(name, m.t, a.d, m.v ? m.relative_velocity(link, a) : still);
    if (axes == Axes::world) return f;
    const auto x = turned(link.j, {1, 0}, m.e), y = turned(link.j, {0, 1}, m.e);
    return {f.x() * x.x() + f.y() * y.x(), f.x() * x.y() + f.y() * y.y()};
  }
};

inline constexpr auto force_axes =
    complete<ForceLoad::Axes>({{ForceLoad::Axes::world, "world", "they stand still"},
                               {ForceLoad::Axes::body, "body", "they turn with the body"}});
constexpr std::span<const Choice<ForceLoad::Axes>> choices(ForceLoad::Axes) { return force_axes; }

}  // namespace freeplay
