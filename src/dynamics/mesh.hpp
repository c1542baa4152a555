// Meshes of involute teeth: of two wheels, and of a wheel and a rack.
//
// One flank of two wheels with involute teeth, at the present distance of the wheels. Signed base
// radii are R_i = r_b,i and R_j = κ r_b,j with κ = +1 for external gears and −1 if wheel i is a
// ring with internal teeth; S = R_i + R_j. Let d = r_j − r_i have length a and the direction
// n = (cos ψ, sin ψ), and let t = perp n, cos α = S/a, L = √(a² − S²). Flank σ (+1: wheel i turning
// counterclockwise pushes, −1: clockwise) acts along the line of action,
//
//     u = σ cos α t + κ sin α n       (the force on wheel j)
//     g = κ S (inv α − inv α₀) + b/2 + σ (S ψ − R_i θ_i − R_j θ_j − φ₀)
//     S inv α = L − S atan(L/S)
//     ġ = u·ḋ − σ (R_i ω_i + R_j ω_j)
//     g̈ = u·d̈ − σ (R_i α_i + R_j α_j) + κ (m·ḋ)²/L,     m = cos α n − σ κ sin α t ⊥ u
//
// because S d(inv α) = sin α da and S ψ̇ = cos α (t·ḋ). L is the distance between the points where
// the line of action is tangent to the base circles. The tooth in mesh is the one with the least
// |S ψ − …|, so that angles may include full turns. (Involute function, base pitch, normal backlash
// b: ISO 21771-1:2007.) At a distance below S there is no mesh: inv α is set to 0.
#pragma once

#include <algorithm>
#include <cmath>

#include "dynamics/gap_motion.hpp"
#include "dynamics/kinematics.hpp"
#include "mechanism/mesh.hpp"
#include "numerics/choice.hpp"

namespace freeplay {

/// A flank at one state.
template <class T>
struct FlankOf {
  T gap;                     ///< m
  Vec2Of<T> along;           ///< u, direction of the force on the second body
  T turn_i = 0, turn_j = 0;  ///< m, coefficients of ω_i and ω_j in ġ
};

/// Prevents a change of tooth from being missed within a step. If the step is long enough for
/// another tooth to come into mesh (`speed`: bound on |ġ|, m/s), the gap may jump by a period P
/// within the step. Between two jumps the flanks move by at least P/2, so intervals of
/// dt = P/(4 speed) contain no jump. An acceleration of 64 speed²/P prevents longer intervals from being
/// decided: over dt it lowers the chord by P/2, the whole range of the gap, and changes a rate by
/// 16 speed.
inline void heed_teeth(GapMotion& m, double period, double speed, double h) {
  if (std::isfinite(period) && speed * h > 0.25 * period)
    m.acceleration = std::max(m.acceleration, 64 * speed * speed / period);
}

struct InvoluteMesh : InvoluteFlank {
  template <class T>
  FlankOf<T> at(const Link& link, const T* q, const Vec2Of<T>& d, const EvaluationOf<T>&) const {
    using std::sqrt, std::cos, std::sin, std::atan2;
    const double S = sum();
    const T middle = (Ri * theta(q, link.i) + Rj * theta(q, link.j) + phase) / S;
    const T c = cos(middle), s = sin(middle), a = sqrt(dot(d, d));
    FlankOf<T> f;
    Vec2Of<T> n{c, s};
    T along = T(0);
    if (a > 1e-9 * S) {
      n = {d.x() / a, d.y() / a};
      along = S * atan2(c * d.y() - s * d.x(), c * d.x() + s * d.y());
      if (std::isfinite(period)) along -= T(period * round_of(along / period));
    }
    const Vec2Of<T> t = perp(n);
    f.gap = rest + side * along;
    const T turning = a > 1e-9 * S ? T(side * S / a) : T(side);
    f.along = {turning * t.x(), turning * t.y()};
    if (a > S) {
      const T L = sqrt(a * a - S * S), radial = kind * L / a;
      f.gap += kind * (L - S * atan2(L, T(S)));
      f.along = {f.along.x() + radial * n.x(), f.along.y() + radial * n.y()};
    }
    f.turn_i = -side * Ri;
    f.turn_j = -side * Rj;
    return f;
  }

  /// Terms of g̈ without linear or angular accelerations.
  template <class T>
  T velocity_terms(const FlankOf<T>& f, const Vec2Of<T>& d, const Vec2Of<T>& rate, const T&, const T&) const {
    using std::sqrt;
    const T L2 = dot(d, d) - sum() * sum(), across = cross(f.along, rate);
    return L2 > 0 ? T(kind * across * across / sqrt(L2)) : T(0);
  }

  /// Bounds on the gap's second derivative within a step; d at its end.
  GapMotion motion(const Link& link, const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    const double S = sum(), near = d.norm() - m.speed * bounds.duration;
    if (m.speed > 0)
      m.acceleration += near > S ? m.speed * m.speed / std::sqrt(near * near - S * S) : INFINITY;
    double speed = m.speed;
    for (const auto& [body, R] : {std::pair{link.i, Ri}, std::pair{link.j, Rj}})
      if (body != ground) {
        m.acceleration += std::abs(R) * bounds.acceleration[planar::first(body) + 2];
        speed += std::abs(R) * bounds.speed[planar::first(body) + 2];
      }
    heed_teeth(m, period, speed, bounds.duration);
    return m;
  }
};

// One flank of a wheel i and a rack: straight teeth on body j along an axis A, with the wheel on
// its left. The flanks are at the pressure angle α at any distance. With d = r_j − r_i to a point
// of the rack's pitch line, r the wheel's pitch radius, r_b = r cos α, and σ as
// above (+1: the wheel turning counterclockwise pushes the rack along A),
//
//     u = σ cos α A − sin α perp A      (the force on the rack; it turns with body j)
//     g = b/2 − r sin α − sin α perp A·d + σ (cos α A·d − r_b (θ_i − θ_j) − φ₀)
//     ġ = u·ḋ + ω_j perp u·d − σ r_b (ω_i − ω_j)
//     g̈ = u·d̈ + α_j perp u·d − σ r_b (α_i − α_j) + 2 ω_j perp u·ḋ − ω_j² u·d

struct RackMesh : RackFlank {
  template <class T>
  FlankOf<T> at(const Link& link, const T* q, const Vec2Of<T>& d, const EvaluationOf<T>& e) const {
    const Vec2Of<T> A = turned(link.j, axis, e), left = perp(A);
    const double along = side * cosine;
    FlankOf<T> f;
    f.along = {along * A.x() - sine * left.x(), along * A.y() - sine * left.y()};
    T x = cosine * dot(A, d) - base * (theta(q, link.i) - theta(q, link.j)) - phase;
    if (std::isfinite(period)) x -= T(period * round_of(x / period));
    f.gap = rest - sine * dot(left, d) + side * x;
    f.turn_i = T(-side * base);
    f.turn_j = dot(perp(f.along), d) + side * base;
    return f;
  }

  template <class T>
  T velocity_terms(const FlankOf<T>& f, const Vec2Of<T>& d, const Vec2Of<T>& rate, const T&,
                   const T& wj) const {
    return 2 * wj * dot(perp(f.along), rate) - wj * wj * dot(f.along, d);
  }

  /// Bounds on the gap's second derivative within a step; d at its end.
  GapMotion motion(const Link& link, const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    double speed = m.speed;
    if (link.i != ground) {
      m.acceleration += base * bounds.acceleration[planar::first(link.i) + 2];
      speed += base * bounds.speed[planar::first(link.i) + 2];
    }
    if (link.j != ground) {
      const int c = planar::first(link.j) + 2;
      const double turn = bounds.speed[c], reach = d.norm() + m.speed * bounds.duration;
      m.acceleration +=
          base * bounds.acceleration[c] + 2 * turn * m.speed + (turn * turn + bounds.acceleration[c]) * reach;
      speed += (base + reach) * turn;
    }
    heed_teeth(m, period, speed, bounds.duration);
    return m;
  }
};

}  // namespace freeplay
