// The coordinate against which a force has kinks; between two kinks the force is smooth.
// Integrators end their steps there. The coordinate is a relative angle, the travel of a point
// along an axis a of the first body, or the distance of two points:
//
//     θ = θ_j − θ_i,     s = a·d,   ṡ = a·ḋ + ω_i perp a·d,   |d|
//     |s̈| ≤ |d̈| + 2 |ω_i ḋ| + (ω_i² + |α_i|) |d|
//
// or the rate of one of these, whose own rate the state does not determine, or the speed b·v of
// the second point along an axis b of the second body.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "dynamics/gap_motion.hpp"
#include "dynamics/kinematics.hpp"
#include "mechanism/piecewise.hpp"

namespace freeplay {

/// The demand of a drive over its limit: at ±1 the force of the drive has a kink.
struct Saturation {
  double share = 0;
  double terms = 0;  ///< sum of the sizes of its terms, over the limit
};

struct Phase {
  static constexpr double turn = 6.283185307179586;
  enum class Of { angle, travel, distance, forward };
  Link link = {};
  std::vector<double> kinks = {};  ///< rad or m, increasing, within one period
  double period = 0;               ///< rad or m; 0: the kinks do not repeat
  Of of = Of::angle;
  Vec2 axis{1, 0};  ///< axis a of a travel, in the first body's frame; b, in the second body's
  /// True for a curve, whose time steps go from kink to kink (integrators/curve_limit.hpp). False
  /// for a spring, at whose kinks steps end.
  bool swept = false;
  /// True if the coordinate is the rate of the angle, travel or distance; always for `forward`.
  bool speed = false;
  /// True for an edge of a contact's outline (dynamics/outline_pair.hpp), at whose ends no force of an
  /// element has a kink.
  bool contact = false;

  /// The coordinate and its rate; the rate of a speed is given as 0.
  Watched at(const double* q, const double* v) const {
    const auto now = place_at(q, v);
    return speed ? Watched{now.rate, 0} : now;
  }
  /// The angle, travel or distance, and its rate.
  Watched place_at(const double* q, const double* v) const {
    if (of == Of::angle) return {theta(q, link.j) - theta(q, link.i), omega(v, link.j) - omega(v, link.i)};
    const Placement placed{q};
    const auto arm = [&](int body, const Vec2& s) { return placed.point(body, s) - centre(q, body); };
    const Arms<double> a{arm(link.i, link.si), arm(link.j, link.sj),
                         placed.point(link.j, link.sj) - placed.point(link.i, link.si)};
    const Vec2 rate = freeplay::relative_velocity(link, a, v);
    if (of == Of::forward)
      return {0, dot(placed.point(link.j, link.sj + axis) - placed.point(link.j, link.sj), rate)};
    if (of == Of::travel) {
      const Vec2 along = placed.point(link.i, link.si + axis) - placed.point(link.i, link.si);
      return {dot(along, a.d), dot(along, rate) + omega(v, link.i) * dot(perp(along), a.d)};
    }
    const double length = a.d.norm();
    return {length, length > 0 ? dot(a.d, rate) / length : 0};
  }

  /// Bounds on the second derivative of the distance to the upper or lower end of a piece, within a
  /// step that ends at q.
  GapMotion motion(const MotionBounds& bounds, const Piece& piece, bool up, const double* q) const {
    const double alpha = omega(bounds.acceleration.data(), link.i);
    if (of == Of::angle)
      return {GapMotion::Shape::straight, 0, alpha + omega(bounds.acceleration.data(), link.j), 0};
    auto m = relative_motion(link, bounds);
    if (of == Of::distance) {
      m.shape = up ? GapMotion::Shape::inside : GapMotion::Shape::outside;
      m.rest = up ? piece.high : piece.low;
      return m;
    }
    if (link.i == ground) {
      if (!contact) return m;
      // A disc may stay above a corner: its motion across the edge has no effect.
      const int c = planar::first(link.j);
      const double turn = bounds.speed[c + 2];
      m.acceleration = std::abs(axis.x()) * bounds.acceleration[c] +
                       std::abs(axis.y()) * bounds.acceleration[c + 1] +
                       link.sj.norm() * (turn * turn + bounds.acceleration[c + 2]);
      return m;
    }
    const Placement placed{q};
    const double turning = omega(bounds.speed.data(), link.i);
    const double reach =
        (placed.point(link.j, link.sj) - placed.point(link.i, link.si)).norm() + m.speed * bounds.duration;
    m.acceleration += 2 * turning * m.speed + (turning * turning + alpha) * reach;
    return m;
  }

  /// The smooth piece that contains x. At a kink (to rounding), the piece above or below it.
  Piece piece(double x, bool above) const { return piece(x, above, 1e-12 * std::fmax(1, std::abs(x))); }
  Piece piece(double x, bool above, double rounding) const {
    const double from = above ? x + rounding : x - rounding;
    const double turns = period > 0 ? std::floor((from - kinks.front()) / period) : 0;
    const double within = from - period * turns;
    std::size_t i = 0;
    while (i < kinks.size() && kinks[i] <= within) ++i;
    // The kinks before and after x, across the ends of the period.
    const double low = i > 0 ? kinks[i - 1] : period > 0 ? kinks.back() - period : -INFINITY;
    const double high = i < kinks.size() ? kinks[i] : period > 0 ? kinks.front() + period : INFINITY;
    return {low + period * turns, high + period * turns};
  }
};

// A curve y(x) of an element as the choice of steps sees it: its argument x and the rate of x. Let
// n be the degree of the stretch that contains x, L its length and λ the period of its sine. The
// length over which y varies is
//
//     λ of a sine,     L for n ≥ 4,     4 L for n = 2, 3,     ∞ for a straight line
//
// A step of a given share of that length resolves the curve
// (formulations/integrators/curve_limit.hpp).

struct CurveReader {
  enum class Of { time, place, speed };
  std::string name;  ///< of the element
  Of of = Of::time;
  /// Angle or travel, whose rate is the speed; its kinks are the knots of the curve.
  Phase place = {};
  Piecewise course = {};

  /// x and its rate. If x is a speed, its rate is unknown here and given as 0.
  Watched argument(double t, const double* q, const double* v) const {
    if (of == Of::time) return {t, 1};
    const auto now = place.place_at(q, v);
    return of == Of::place ? now : Watched{now.rate, 0};
  }
  /// The length over which y varies at x; at a knot, that of the stretch above or below.
  double variation(double x, bool above) const {
    const double rounding = 1e-12 * std::fmax(1, std::abs(x));
    return course.variation(above ? x + rounding : x - rounding);
  }
};

/// Curves and tables of a System.
struct CurveFacts {
  std::vector<Phase> phases;
  /// Of curves that are not constant; prescribed motions come first.
  std::vector<CurveReader> readers;
  /// Whether a table acts by its mean over the interval that a time step covers.
  bool sweeps = false;
  /// Whether a spring force has a phase with kinks; such a force has no pulses.
  bool spring_kinks = false;
};

}  // namespace freeplay
