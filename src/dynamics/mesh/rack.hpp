// One flank of a wheel i and a rack: straight teeth on body j along an axis A, with the wheel on
// its left. The flanks are at the pressure angle α at any distance. With d = r_j − r_i to a point
// of the rack's pitch line, r the wheel's pitch radius, r_b = r cos α, and σ as in
// mesh/involute.hpp (+1: the wheel turning counterclockwise pushes the rack along A),
//
//     u = σ cos α A − sin α perp A      (the force on the rack; it turns with body j)
//     g = b/2 − r sin α − sin α perp A·d + σ (cos α A·d − r_b (θ_i − θ_j) − φ₀)
//     ġ = u·ḋ + ω_j perp u·d − σ r_b (ω_i − ω_j)
//     g̈ = u·d̈ + α_j perp u·d − σ r_b (α_i − α_j) + 2 ω_j perp u·ḋ − ω_j² u·d
#pragma once

#include <cmath>

#include "dynamics/mesh/involute.hpp"

namespace freeplay {

struct RackMesh : RackFlank {
  template <class T>
  FlankOf<T> at(const Link& link, const T* q, const Vec2Of<T>& d, const EvaluationOf<T>& e) const {
    const Vec2Of<T> A = turned(link.j, axis, e), left = perp(A);
    const double along = side * cosine;
    FlankOf<T> f;
    f.along = {along * A.x() - sine * left.x(), along * A.y() - sine * left.y()};
    T x = cosine * dot(A, d) - base * (theta(q, link.i) - theta(q, link.j)) - phase;
    if (std::isfinite(period)) x -= T(period * round_of(place_of(x) / period));
    f.gap = rest - sine * dot(left, d) + side * x;
    f.turn_i = T(-side * base);
    f.turn_j = dot(perp(f.along), d) + side * base;
    return f;
  }

  template <class T>
  T bend(const FlankOf<T>& f, const Vec2Of<T>& d, const Vec2Of<T>& rate, const T&, const T& wj) const {
    return 2 * wj * dot(perp(f.along), rate) - wj * wj * dot(f.along, d);
  }

  /// Bounds on the gap's second derivative within a step; d at its end.
  GapMotion motion(const Link& link, const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    double speed = m.speed;
    if (link.i != ground) {
      m.bend += base * bounds.acceleration[planar::first(link.i) + 2];
      speed += base * bounds.speed[planar::first(link.i) + 2];
    }
    if (link.j != ground) {
      const int c = planar::first(link.j) + 2;
      const double turn = bounds.speed[c], reach = d.norm() + m.speed * bounds.duration;
      m.bend +=
          base * bounds.acceleration[c] + 2 * turn * m.speed + (turn * turn + bounds.acceleration[c]) * reach;
      speed += (base + reach) * turn;
    }
    heed_teeth(m, period, speed, bounds.duration);
    return m;
  }
};

}  // namespace freeplay
