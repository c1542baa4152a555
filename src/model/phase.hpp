// An angle or place whose table has kinks, as integrators see it: between two of them the force is smooth.
#pragma once

#include <cmath>
#include <vector>

#include "model/kinematics.hpp"

namespace freeplay {

struct Phase {
  Link link;
  std::vector<double> kinks;          ///< rad or m, increasing, within one period; not empty
  double period = 6.283185307179586;  ///< 0: they do not repeat
  bool slides = false;                ///< the place along the first body's axis, else the angle
  Vec2 axis{1, 0};

  /// Beyond the first and the last kink of those that do not repeat (rad or m).
  static constexpr double far = 1e7;

  /// The piece that an angle is on; where it stands on a kink (to rounding), the one above or below.
  Piece piece(double angle, bool above) const {
    const double rounding = 1e-12 * std::fmax(1, std::abs(angle));
    const double from = above ? angle + rounding : angle - rounding;
    const double turns = period > 0 ? std::floor((from - kinks.front()) / period) : 0;
    const double x = from - period * turns;
    std::size_t i = 0;
    while (i < kinks.size() && kinks[i] <= x) ++i;
    // The kinks before and after x, over the ends of the period.
    const double low = i > 0 ? kinks[i - 1] : period > 0 ? kinks.back() - period : kinks.front() - far;
    const double high = i < kinks.size() ? kinks[i]
                        : period > 0     ? kinks.front() + period
                                         : kinks.back() + far;
    return {low + period * turns, high + period * turns};
  }
  /// The angle or place and its rate.
  std::array<double, 2> motion(const double* q, const double* v) const {
    if (!slides) return {theta(q, link.j) - theta(q, link.i), omega(v, link.j) - omega(v, link.i)};
    const Placement at{q};
    const double turn = theta(q, link.i), c = std::cos(turn), s = std::sin(turn);
    const Vec2 along{c * axis.x() - s * axis.y(), s * axis.x() + c * axis.y()};
    const Vec2 first = at.point(link.i, link.si), second = at.point(link.j, link.sj), d = second - first;
    const auto velocity = [&](int body, const Vec2& point) {
      return body == ground ? Vec2{0, 0} : centre(v, body) + omega(v, body) * perp(point - centre(q, body));
    };
    return {dot(along, d), dot(along, velocity(link.j, second) - velocity(link.i, second))};
  }
  /// The farthest kink from 0.
  double reach() const { return std::fmax(std::abs(kinks.front()), std::abs(kinks.back())); }
};

}  // namespace freeplay
