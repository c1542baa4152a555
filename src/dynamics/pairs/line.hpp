// A disc of radius R (0: a corner) of body j against a wall along the axis a of body i. With n = s perp a into
// the free space, d = r_j − r_i, y = n·d − R the contact point's distance from body i's point along n:
//
//     g = n·d − rest,    ġ = n·ḋ − s ω_i a·d,    g̈ = n·d̈ − s α_i a·d − 2 s ω_i a·ḋ − ω_i² n·d
//     v_T = a·ḋ + s R ω_j + s y ω_i,             v̇_T = a·d̈ + ω_i perp(a)·ḋ + s(ω_i ġ + R α_j + y α_i)
#pragma once

#include "dynamics/pairs/pair.hpp"

namespace freeplay {

struct LinePair {
  Link link;
  double side = 1;  ///< s: free space on the left (+1) or right of the axis
  Vec2 axis{1, 0};
  double rest = 0;    ///< m: what n·d is short of the gap
  double radius = 0;  ///< m, R

  double gap(const Vec2& d, const Evaluation& e) const {
    return side * dot(perp(turned(link.i, axis, e)), d) - rest;
  }
  /// How the gap may bend within a step; d at its end. A wall that turns adds n̈·d + 2ṅ·ḋ, |ṅ| ≤ |ω_i|.
  GapMotion motion(const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    if (link.i == ground) {  // the wall stands still: what goes along it does not count
      const int c = planar::first(link.j);
      const double turn = bounds.speed[c + 2];
      m.bend = std::abs(axis.y()) * bounds.acceleration[c] + std::abs(axis.x()) * bounds.acceleration[c + 1] +
               link.sj.norm() * (turn * turn + bounds.acceleration[c + 2]);
      return m;
    }
    const int c = planar::first(link.i) + 2;
    const double turn = bounds.speed[c];
    const double reach = d.norm() + m.speed * bounds.duration;
    m.bend += 2 * turn * m.speed + (turn * turn + bounds.acceleration[c]) * reach;
    return m;
  }

  /// What share of what it can pass through a contact moves in a time h: the arc below the wall of a point on an arm
  /// that turns, as long as the arm's diameter. What falls through stays below.
  double passage(const double* v, double h) const {
    if (link.j == ground || link.sj.is_zero()) return 0;
    return 0.5 * std::abs(planar::rate(v, link.j)) * h;
  }

  template <class T>
  void rows(const ContactFacts& facts, const Arms<T>& a, const T* v, const EvaluationOf<T>& e,
            ContactRowOf<T>& row) const {
    const int i = link.i, j = link.j;
    const double s = side;
    const Vec2Of<T> wall = turned(i, axis, e), left = perp(wall), n{s * left.x(), s * left.y()};
    const Vec2Of<T> rate = relative_velocity(link, a, v);
    const T wi = omega(v, i), wj = omega(v, j), along = dot(wall, a.d), height = dot(n, a.d);
    const Vec2Of<T> still = centripetal(a.ri, wi, a.rj, wj), back = -n;
    row.gap = height - rest;
    row.gamma_n = 2 * s * wi * dot(wall, rate) + wi * wi * height - dot(n, still);
    push(row.normal, i, back, T(cross(a.ri, back) - s * along));
    push(row.normal, j, n, cross(a.rj, n));
    if (!facts.surface.friction) return;
    const T y = height - radius, closing = dot(n, rate) - s * wi * along;
    row.gamma_t = -(dot(wall, still) + wi * dot(left, rate) + s * wi * closing);
    const Vec2Of<T> behind = -wall;
    push(row.tangent, i, behind, T(cross(a.ri, behind) + s * y));
    push(row.tangent, j, wall, T(cross(a.rj, wall) + s * radius));
  }
};

}  // namespace freeplay
