// Evaluation of the curves of drives and loads at their argument (mechanism/argument.hpp). In a
// time step that covers an interval of x, the mean of the curve over the interval is used, so that
// no pulse falls between two steps.
#pragma once

#include <optional>
#include <type_traits>
#include <utility>

#include "dynamics/kinematics.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/argument.hpp"
#include "mechanism/piecewise.hpp"
#include "numerics/choice.hpp"

namespace freeplay {

/// The joint whose angle is the argument, as a link.
struct ReadJoint {
  int of = -1;  ///< OtherJoint::of
  Link link = {};
  const Link& or_own(const Link& own) const { return of >= 0 ? link : own; }
};

/// y at the argument. `place`: present angle or position; `rate(v)`: its rate at these velocities.
template <class T, class M, class Rate>
T read_at(const Piecewise& y, Argument x, const M& m, const T& place, Rate rate) {
  if (y.is_constant()) return y.value(T(0));
  const auto on_piece = [&](const T& at) { return m.piece ? y.value(at, m.piece->inside()) : y.value(at); };
  if (x == Argument::speed) return on_piece(rate(m.v));
  if (const auto* s = m.reading.sweep) {
    if (x == Argument::time) return y.mean(m.t - 0.5 * s->h, m.t + 0.5 * s->h);
    const T from = place - 0.5 * s->h * rate(s->start);
    return y.mean(from, from + s->h * rate(s->mean));
  }
  if (x == Argument::time) return y.value(m.t);
  return on_piece(place);
}

/// The kinks at which integrators must end steps, if there are any.
inline std::optional<Phase> phase_of(const Piecewise& y, Argument x, const Link& link,
                                     const Vec2* axis = nullptr) {
  if (x == Argument::time) return {};
  auto knots = y.knots();
  if (knots.empty()) return {};
  Phase phase{link, std::move(knots), y.period()};
  phase.swept = true;
  phase.speed = x == Argument::speed;
  if (axis) {
    phase.of = Phase::Of::travel;
    phase.axis = *axis;
  }
  return phase;
}

/// The curve as the choice of steps sees it; empty if it is constant. `axis`: of a travel, in the
/// first body's frame.
inline std::optional<CurveReader> reader_of(const std::string& name, const Piecewise& y, Argument x,
                                            const Link& link, const Vec2* axis = nullptr) {
  if (y.is_constant()) return {};
  CurveReader reader{name, CurveReader::Of::place, {link, y.knots(), y.period()}, y};
  if (x == Argument::time) reader.of = CurveReader::Of::time;
  if (x == Argument::speed) reader.of = CurveReader::Of::speed;
  if (axis) {
    reader.place.of = Phase::Of::travel;
    reader.place.axis = *axis;
  }
  return reader;
}

/// y at the angle of a link.
template <class T, class M>
T read_at_angle(const Piecewise& y, const M& m, const Link& link) {
  return read_at<T>(y, Argument::angle, m, m.angle(link),
                    [&](const auto* v) { return omega(v, link.j) - omega(v, link.i); });
}

/// A drive or load with a curve of its argument. Without a `factor` a load has no curve.
template <class Facts>
struct CurveDynamics : Facts {
  Piecewise course = {};  ///< set by prepare()
  ReadJoint read{this->other.of};

  void prepare(const auto& mechanism) {
    if (reads()) course = mechanism.curves[this->factor].lay();
  }
  bool reads() const {
    if constexpr (requires { this->factor; })
      return this->factor >= 0;
    else
      return true;
  }
  bool does_work() const { return true; }
  bool needs_velocity() const { return reads() && this->against != Argument::time; }
  double next_knot(double t) const {
    return reads() && this->against == Argument::time ? course.next_knot(t) : INFINITY;
  }
  std::optional<Phase> phase(const Link& link) const {
    return reads() ? phase_of(course, this->against, read.or_own(link)) : std::nullopt;
  }
  std::optional<CurveReader> reader(const Link& link) const {
    return reads() ? reader_of(this->name, course, this->against, read.or_own(link)) : std::nullopt;
  }
  /// y at the angle or its rate, or at the time.
  template <class T>
  T read_turning(const auto& m, const Link& link) const {
    const Link& at = read.or_own(link);
    return read_at<T>(course, this->against, m, m.angle(at),
                      [&](const T* v) { return omega(v, at.j) - omega(v, at.i); });
  }
};

/// Geometry of a force along the axis of a sliding joint. The force acts on both bodies at the
/// second one's point.
template <class T>
struct AlongAxis {
  Arms<T> arms;
  Vec2Of<T> axis;
  T place;

  AlongAxis(const Link& link, const Vec2& own_axis, const T* q, const EvaluationOf<T>& e)
      : arms(freeplay::arms(link, q, e)), axis(turned(link.i, own_axis, e)), place(dot(axis, arms.d)) {
    arms.ri += arms.d;
  }
  T rate(const Link& link, const T* v) const { return dot(axis, relative_velocity(link, arms, v)); }
};

}  // namespace freeplay
