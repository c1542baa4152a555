// A coordinate at which a table or a one-way force has kinks, as integrators see it: between two of them the force is
// smooth. A relative angle of a table that repeats every turn, one of a spring that does not, or the distance of two points.
#pragma once

#include <cmath>
#include <vector>

#include "model/gap_motion.hpp"
#include "model/kinematics.hpp"

namespace freeplay {

struct Phase {
  static constexpr double turn = 6.283185307179586;
  enum class Of { turn, angle, distance };
  Link link;
  std::vector<double> kinks;  ///< rad or m, increasing, of `turn` within one; not empty
  Of of = Of::turn;

  /// The coordinate and its rate.
  Watched at(const double* q, const double* v) const {
    if (of != Of::distance) return {theta(q, link.j) - theta(q, link.i), omega(v, link.j) - omega(v, link.i)};
    const Placement placed{q};
    const auto arm = [&](int body, const Vec2& s) { return placed.point(body, s) - centre(q, body); };
    const Arms<double> a{arm(link.i, link.si), arm(link.j, link.sj),
                         placed.point(link.j, link.sj) - placed.point(link.i, link.si)};
    const double length = a.d.norm();
    return {length, length > 0 ? dot(a.d, freeplay::relative_velocity(link, a, v)) / length : 0};
  }

  /// How what is left of a piece, upwards or downwards, may bend within a step.
  GapMotion motion(const MotionBounds& bounds, const Piece& piece, bool up) const {
    if (of == Of::distance) {
      auto m = relative_motion(link, bounds);
      m.shape = up ? GapMotion::Shape::inside : GapMotion::Shape::outside;
      m.rest = up ? piece.high : piece.low;
      return m;
    }
    const auto* a = bounds.acceleration.data();
    return {GapMotion::Shape::straight, 0, omega(a, link.i) + omega(a, link.j), 0};
  }

  /// The piece that a coordinate is on; where it stands on a kink (to rounding), the one above or below.
  Piece piece(double x, bool above) const { return piece(x, above, 1e-12 * std::fmax(1, std::abs(x))); }
  Piece piece(double x, bool above, double rounding) const {
    const double from = above ? x + rounding : x - rounding;
    if (of != Of::turn) {
      std::size_t i = 0;
      while (i < kinks.size() && kinks[i] <= from) ++i;
      return {i > 0 ? kinks[i - 1] : -INFINITY, i < kinks.size() ? kinks[i] : INFINITY};
    }
    const double turns = std::floor((from - kinks.front()) / turn);
    const double within = from - turn * turns;
    std::size_t i = 0;
    while (i < kinks.size() && kinks[i] <= within) ++i;
    // The kinks before and after it, over the ends of the turn.
    const double low = i > 0 ? kinks[i - 1] : kinks.back() - turn;
    const double high = i < kinks.size() ? kinks[i] : kinks.front() + turn;
    return {low + turn * turns, high + turn * turns};
  }
};

}  // namespace freeplay
