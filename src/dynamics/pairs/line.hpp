// A disc of radius R (0: a corner) of body j and a wall along the axis a of body i. n = s perp a
// points into the free space, d = r_j − r_i, y = n·d − R is the distance of the contact point from
// body i's point along n:
//
//     g = n·d − rest,    ġ = n·ḋ − s ω_i a·d,    g̈ = n·d̈ − s α_i a·d − 2 s ω_i a·ḋ − ω_i² n·d
//     v_T = a·ḋ + s R ω_j + s y ω_i,        v̇_T = a·d̈ + ω_i perp(a)·ḋ + s(ω_i ġ + R α_j + y α_i)
#pragma once

#include "dynamics/pairs/pair.hpp"

namespace freeplay {

struct LinePair {
  Link link;
  double side = 1;  ///< s, +1: free space on the left of the axis, −1: on the right
  Vec2 axis{1, 0};
  double rest = 0;    ///< m, n·d at contact
  double radius = 0;  ///< m, R

  double gap(const Vec2& d, const Evaluation& e) const {
    return side * dot(perp(turned(link.i, axis, e)), d) - rest;
  }
  /// Bounds on the gap's second derivative within a step; d at its end. A turning wall adds
  /// n̈·d + 2ṅ·ḋ with |ṅ| ≤ |ω_i|.
  GapMotion motion(const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    if (link.i == ground) {  // fixed wall: motion along it has no effect
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

  /// Motion within a time h as a share of the motion that could pass the contact undetected: the
  /// arc below the wall of a point on a turning arm, as long as the arm's diameter. A point that
  /// passes through without turning stays below.
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
