// Stop of a joint's angle θ = θ_j − θ_i at a radius r. With c the direction from the joint to the
// stop, fixed in body i, n = −s perp c (s = +1 for the greatest angle, −1 for the least),
// d = r_j − r_i:
//
//     g = s r (limit − θ) + n·d,     ġ = −s r (ω_j − ω_i) + n·ḋ + ω_i perp n·d
//     g̈ = −s r (α_j − α_i) + n·d̈ + α_i perp n·d + 2 ω_i perp n·ḋ − ω_i² n·d
//
// The force thus acts through the stop's point. Without a direction n = 0: two opposite stops, a
// couple.
#pragma once

#include "dynamics/pairs/pair.hpp"

namespace freeplay {

struct AngleStopPair {
  Link link;
  double side = 1;    ///< s
  double limit = 0;   ///< rad
  double radius = 0;  ///< m, r
  Vec2 normal{0, 0};  ///< n in the first body's frame; zero: a couple

  double gap(const double* q, const Vec2& d, const Evaluation& e) const {
    return side * radius * (limit - (theta(q, link.j) - theta(q, link.i))) +
           dot(turned(link.i, normal, e), d);
  }
  /// Bounds on the gap's second derivative within a step; d at its end.
  GapMotion motion(const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    if (normal.is_zero()) m.bend = 0;
    for (const int body : {link.i, link.j})
      if (body != ground) m.bend += radius * bounds.acceleration[planar::first(body) + 2];
    if (link.i == ground || normal.is_zero()) return m;
    const int c = planar::first(link.i) + 2;
    const double turn = bounds.speed[c], reach = d.norm() + m.speed * bounds.duration;
    m.bend += 2 * turn * m.speed + (turn * turn + bounds.acceleration[c]) * reach;
    return m;
  }
  /// Zero: a closed stop cannot be passed through.
  double passage(const double*, double) const { return 0; }

  template <class T>
  void rows(const Arms<T>& a, const T* q, const T* v, const EvaluationOf<T>& e, ContactRowOf<T>& row) const {
    const int i = link.i, j = link.j;
    const T wi = omega(v, i), turn = T(side * radius);
    const Vec2Of<T> n = turned(i, normal, e), back = -n, left = perp(n);
    const T height = dot(n, a.d);
    row.gap = side * radius * (limit - (theta(q, j) - theta(q, i))) + height;
    row.gamma_n = -(dot(n, centripetal(a.ri, wi, a.rj, omega(v, j))) +
                    2 * wi * dot(left, relative_velocity(link, a, v)) - wi * wi * height);
    push(row.normal, i, back, T(cross(a.ri, back) + dot(left, a.d) + turn));
    push(row.normal, j, n, T(cross(a.rj, n) - turn));
  }
};

}  // namespace freeplay
