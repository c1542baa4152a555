// Bounds on a gap within a step, from bounds on the motion of the bodies. Let d be the vector from
// the first body's point to the second's, s_i and s_j their arms. With bounds on the bodies'
// velocities and accelerations over the step,
//
//     |ḋ| ≤ |ẋ_j − ẋ_i| + Σ |s| |ω|,     |d̈| ≤ |ẍ_j − ẍ_i| + Σ |s| (ω² + |α|).
//
// Between two times h apart, |d| is convex up to a term of |d̈|: it is at most the greater end
// value plus |d̈|h²/8, and −|d̈| ≤ |d|″ ≤ |d̈| + |ḋ|²/|d|. For the distance to a turning wall only
// bounds on its second derivative are used. The distance to a profile with hollows is the least of
// several branches: its rate drops where the nearest point changes, which happens only beyond some
// distance, the reach. There, only the bound on the rate is used. From these bounds event detection
// proves, without sampling, that a gap or its rate keeps its sign.
//
// Usage: MotionBounds::enclose() bounds the motion of a step, System::gap_motion() gives the
// GapMotion of a contact, and least(), rises() and falls() decide an interval between two instants
// (integrators/crossing.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <vector>

#include "dynamics/evaluation.hpp"
#include "dynamics/kinematics.hpp"
#include "dynamics/planar.hpp"

namespace freeplay {

/// Value and rate of a monitored function.
struct Watched {
  double value = 0, rate = 0;
};

/// Bounds on the rate and the acceleration of one coordinate over a step. T is double, or a vector of
/// them for several coordinates.
template <class T>
struct CubicBounds {
  T speed, acceleration;
};
/// Bounds for the cubic through rates and accelerations at both ends of a step of length h, which
/// lies within its control points. If the cubic through positions and rates bends more, its bound
/// is used.
template <class T>
CubicBounds<T> cubic_bounds(double h, const T& q0, const T& v0, const T& a0, const T& q1, const T& v1,
                            const T& a1) {
  const auto more = [](const T& x, const T& y) -> T { return x < y ? y : x; };
  const auto size = [&](const T& x) -> T { return more(x, -x); };
  const double third = h / 3, per = 1 / h;
  const T slope = 6 * per * (q1 - q0) - 3.0 * (v0 + v1), tilt = v1 - v0;
  return {
      more(more(size(v0), size(v1)), more(size(v0 + third * a0), size(v1 - third * a1))),
      more(more(more(size(a0), size(a1)), size(3 * per * tilt - a0 - a1)), per * (size(slope) + size(tilt)))};
}

/// Bounds on the rates and accelerations of all coordinates over a step.
struct MotionBounds {
  std::vector<double> speed, acceleration;  ///< m/s, m/s² or rad/s, rad/s²; one per coordinate
  double duration = 0;                      ///< s

  /// Sets the bounds for a step of length h by cubic_bounds; each array has n entries.
  void enclose(double h, std::size_t n, const double* q0, const double* v0, const double* a0,
               const double* q1, const double* v1, const double* a1) {
    duration = h;
    speed.resize(n);
    acceleration.resize(n);
    using Pair = double __attribute__((vector_size(16)));
    const auto bound = [&]<class T>(std::size_t i, const T&) {
      const auto at = [i](const double* x) {
        T value;
        std::memcpy(&value, x + i, sizeof value);
        return value;
      };
      const auto b = cubic_bounds(h, at(q0), at(v0), at(a0), at(q1), at(v1), at(a1));
      std::memcpy(&speed[i], &b.speed, sizeof(T));
      std::memcpy(&acceleration[i], &b.acceleration, sizeof(T));
    };
    std::size_t i = 0;
    for (; i + 2 <= n; i += 2) bound(i, Pair{});
    if (i < n) bound(i, 0.0);
  }
  /// Widens the bounds for an interpolant whose rate of coordinate i differs from that cubic by up
  /// to `apart`, and whose derivative differs by up to `steep` times that over the step's length.
  void widen(std::size_t i, double apart, double steep) {
    speed[i] += apart;
    acceleration[i] += steep / duration * apart;
  }
};

/// Bounds on the curve of a monitored distance y within a step.
struct GapMotion {
  /// outside: y = |d| − rest. inside: y = rest − |d|. straight: distance along or to a wall. curved:
  /// distance to a profile.
  enum class Shape { outside, inside, straight, curved };
  Shape shape = Shape::straight;
  double speed = 0;         ///< m/s, bound on |ḋ|; for a profile on |ẏ|
  double acceleration = 0;  ///< m/s², bound on |d̈|; for a wall or a profile on |ÿ|
  double rest = 0;          ///< m
  double reach = INFINITY;  ///< m; `acceleration` holds below this distance

  /// The bounds of −y.
  GapMotion opposite() const {
    auto m = *this;
    if (shape == Shape::inside || shape == Shape::outside)
      m.shape = shape == Shape::inside ? Shape::outside : Shape::inside;
    return m;
  }

  /// A lower bound of y between the states a and b, which are h apart in time.
  double least(const Watched& a, const Watched& b, double h) const {
    if (beyond(a, b, h)) return 0.5 * (a.value + b.value - speed * h);
    // Inside, |d| is at most its greater end value plus the term of |d̈|. Outside, |d| may be
    // smaller between the ends.
    const double chord =
        shape == Shape::outside ? -INFINITY : std::min(a.value, b.value) - 0.125 * acceleration * h * h;
    const double down = acceleration_bounds(a, b, h).down;
    if (!std::isfinite(down)) return chord;
    // y + ½ down (t − a)(t − b) is convex, so it lies above its tangents; y lies above it.
    const double fall = a.rate - 0.5 * down * h, rise = b.rate + 0.5 * down * h;
    double low = std::min(a.value, b.value);
    if (fall < 0 && rise > 0) {
      const double s = (b.value - a.value - rise * h) / (fall - rise);
      low = std::min(low, a.value + fall * std::clamp(s, 0.0, h));
    }
    return std::max(low, chord);
  }
  /// Whether y is proved to increase, or to decrease, throughout.
  bool rises(const Watched& a, const Watched& b, double h) const {
    const auto [down, up] = acceleration_bounds(a, b, h);
    return !beyond(a, b, h) && one_way(a.rate, b.rate, h, down, up);
  }
  bool falls(const Watched& a, const Watched& b, double h) const {
    const auto [down, up] = acceleration_bounds(a, b, h);
    return !beyond(a, b, h) && one_way(-a.rate, -b.rate, h, up, down);
  }

 private:
  struct AccelerationBounds {
    double down, up;  ///< −down ≤ ÿ ≤ up
  };
  /// Whether the distance may leave the reach.
  bool beyond(const Watched& a, const Watched& b, double h) const {
    return std::isfinite(reach) && 0.5 * (a.value + b.value + speed * h) > reach;
  }
  AccelerationBounds acceleration_bounds(const Watched& a, const Watched& b, double h) const {
    if (shape == Shape::straight || shape == Shape::curved) return {acceleration, acceleration};
    const double sign = shape == Shape::outside ? 1 : -1;
    const double length = std::max(rest + sign * a.value, rest + sign * b.value) - speed * h;
    const double swirl = length > 0 ? acceleration + speed * speed / length : INFINITY;
    return sign > 0 ? AccelerationBounds{acceleration, swirl} : AccelerationBounds{swirl, acceleration};
  }
  /// Whether a rate with end values ra and rb, which decreases by at most `down` and increases by
  /// at most `up` per unit time, stays positive.
  static bool one_way(double ra, double rb, double h, double down, double up) {
    if (!(ra > 0 && rb > 0) || !std::isfinite(down + up)) return false;
    const double both = down + up;
    const double s = both > 0 ? std::clamp((ra - rb + up * h) / both, 0.0, h) : 0;
    return ra - down * s > 0;
  }
};

/// Bound on the relative motion of a link's points within h (s) at these rates, along arcs:
/// |ẋ_j − ẋ_i| h + Σ |s| |ω| h.
inline double path(const Link& link, const double* v, double h) {
  Vec2 across{0, 0};
  double along = 0;
  for (const auto& [body, arm, sign] :
       {std::tuple{link.i, link.si, -1.0}, std::tuple{link.j, link.sj, 1.0}}) {
    if (body == ground) continue;
    across += sign * planar::velocity(v, body);
    along += arm.norm() * std::abs(planar::rate(v, body));
  }
  return (across.norm() + along) * h;
}

/// Bounds on the motion of a link's second point relative to its first.
inline GapMotion relative_motion(const Link& link, const MotionBounds& b) {
  double vx = 0, vy = 0, ax = 0, ay = 0;
  GapMotion m;
  const auto add = [&](int body, const Vec2& arm) {
    if (body == ground) return;
    const int c = planar::first(body);
    vx += b.speed[c];
    vy += b.speed[c + 1];
    ax += b.acceleration[c];
    ay += b.acceleration[c + 1];
    const double length = arm.norm(), turn = b.speed[c + 2];
    m.speed += length * turn;
    m.acceleration += length * (turn * turn + b.acceleration[c + 2]);
  };
  add(link.i, link.si);
  add(link.j, link.sj);
  m.speed += std::sqrt(vx * vx + vy * vy);
  m.acceleration += std::sqrt(ax * ax + ay * ay);
  return m;
}

}  // namespace freeplay
