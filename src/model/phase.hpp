// What a force has kinks against, as integrators see it: between two of them the force is smooth. An angle with a torque
// table, which repeats every turn; or the angle or travel of a bump stop, which does not:
//
//     θ = θ_j − θ_i,     x = a·d,   ẋ = a·ḋ + ω_i perp a·d,   |ẍ| ≤ |d̈| + 2 |ω_i ḋ| + (ω_i² + |α_i|) |d|
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "model/gap_motion.hpp"
#include "model/kinematics.hpp"

namespace freeplay {

struct Phase {
  static constexpr double turn = 6.283185307179586;
  Link link;
  std::vector<double> kinks;      ///< rad, within one turn where they repeat, or m; increasing, not empty
  bool repeats = true;            ///< every turn
  std::optional<Vec2> axis = {};  ///< a in the first body's frame, of a travel; absent: an angle

  /// Its value and rate at a state.
  Watched at(const double* q, const double* v) const {
    if (!axis) return {theta(q, link.j) - theta(q, link.i), omega(v, link.j) - omega(v, link.i)};
    const Placement placed{q};
    const Vec2 from = placed.point(link.i, link.si), d = placed.point(link.j, link.sj) - from;
    const Vec2 along = placed.point(link.i, link.si + *axis) - from;
    const auto velocity = [&](int body, const Vec2& s) -> Vec2 {
      if (body == ground) return {0, 0};
      return centre(v, body) + omega(v, body) * perp(placed.point(body, s) - centre(q, body));
    };
    return {dot(along, d), dot(along, velocity(link.j, link.sj) - velocity(link.i, link.si)) +
                               omega(v, link.i) * dot(perp(along), d)};
  }
  /// Bound on its acceleration over a step that ends at q.
  double bend(const MotionBounds& bounds, const double* q) const {
    const double alpha = omega(bounds.acceleration.data(), link.i);
    if (!axis) return alpha + omega(bounds.acceleration.data(), link.j);
    const auto m = relative_motion(link, bounds);
    if (link.i == ground) return m.bend;
    const Placement placed{q};
    const double turning = omega(bounds.speed.data(), link.i);
    const double reach =
        (placed.point(link.j, link.sj) - placed.point(link.i, link.si)).norm() + m.speed * bounds.duration;
    return m.bend + 2 * turning * m.speed + (turning * turning + alpha) * reach;
  }

  /// The piece that it is on; where it stands on a kink (to rounding), the one above or below.
  Piece piece(double value, bool above) const {
    const double rounding = 1e-12 * std::fmax(1, std::abs(value));
    const double from = above ? value + rounding : value - rounding;
    if (!repeats) return single(from);
    const double turns = std::floor((from - kinks.front()) / turn);
    const double x = from - turn * turns;
    std::size_t i = 0;
    while (i < kinks.size() && kinks[i] <= x) ++i;
    // The kinks before and after x, over the ends of the turn.
    const double low = i > 0 ? kinks[i - 1] : kinks.back() - turn;
    const double high = i < kinks.size() ? kinks[i] : kinks.front() + turn;
    return {low + turn * turns, high + turn * turns};
  }

 private:
  /// Beyond the first and the last kink pieces have some length, so that their ends are numbers.
  Piece single(double x) const {
    const double size = std::fmax(std::abs(kinks.front()), std::abs(kinks.back()));
    const double length = size > 0 ? 100 * size : 1;
    if (x < kinks.front()) {
      const double high = kinks.front() - length * std::floor((kinks.front() - x) / length);
      return {high - length, high};
    }
    if (x >= kinks.back()) {
      const double low = kinks.back() + length * std::floor((x - kinks.back()) / length);
      return {low, low + length};
    }
    const auto next = std::ranges::upper_bound(kinks, x);
    return {*(next - 1), *next};
  }
};

}  // namespace freeplay
