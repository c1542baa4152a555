// Dynamics of mechanism/elements/force_load.hpp, which states the equations.
#pragma once

#include "dynamics/argument.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/elements/force_load.hpp"
#include "mechanism/piecewise.hpp"

namespace freeplay {

template <>
struct Dynamics<ForceLoad> : CurveDynamics<ForceLoad> {
  auto link(auto& b) const { return b.free_link({ground, body}, {Vec2{0, 0}, at}); }
  bool needs_velocity() const { return own || (factor >= 0 && against != Argument::time); }
  double next_knot(double t) const {
    return !own && factor >= 0 && against == Argument::time ? course.next_knot(t) : INFINITY;
  }
  std::optional<Phase> phase(const Link& link) const {
    if (own || factor < 0) return {};
    const Vec2 along = force.is_zero() ? force : force.direction();
    auto phase = phase_of(course, against, read.or_own(link), against == Argument::angle ? nullptr : &along);
    if (phase && forward()) phase->of = Phase::Of::forward;
    return phase;
  }
  std::optional<CurveReader> reader(const Link& link) const {
    if (own || factor < 0) return {};
    const Vec2 along = force.is_zero() ? force : force.direction();
    auto reader =
        reader_of(name, course, against, read.or_own(link), against == Argument::angle ? nullptr : &along);
    if (reader && forward()) reader->place.of = Phase::Of::forward;
    return reader;
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
  bool forward() const { return axes == Axes::body && against == Argument::speed; }
  template <class T>
  Vec2Of<T> scaled(const auto& m, const auto& link, const Arms<T>& a, const Vec2Of<T>& f) const {
    const auto moves = [&](const T* v) { return dot(f, relative_velocity(link, a, v)) / force.norm(); };
    const T s = against == Argument::angle
                    ? read_at_angle<T>(course, m, read.or_own(link))
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

}  // namespace freeplay
