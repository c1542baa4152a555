// One flank of two wheels with involute teeth, on the distance that the wheels have. Signed base radii R_i = r_b,i and
// R_j = κ r_b,j with κ = +1 outside each other, −1 where wheel i is a ring with its teeth inside; S = R_i + R_j. With
// d = r_j − r_i of length a in the direction n = (cos ψ, sin ψ), t = perp n, cos α = S/a and L = √(a² − S²), flank σ
// (+1: wheel i turning counter-clockwise pushes, −1: clockwise) acts along the line of action,
//
//     u = σ cos α t + κ sin α n       (the force on wheel j)
//     g = κ S (inv α − inv α₀) + b/2 + σ (S ψ − R_i θ_i − R_j θ_j − φ₀),    S inv α = L − S atan(L/S)
//     ġ = u·ḋ − σ (R_i ω_i + R_j ω_j)
//     g̈ = u·d̈ − σ (R_i α_i + R_j α_j) + κ (m·ḋ)²/L,     m = cos α n − σ κ sin α t ⊥ u
//
// for S d(inv α) = sin α da and S ψ̇ = cos α (t·ḋ). L is the distance between the points where the line of action touches
// the base circles. The tooth that is in mesh is the one of the least |S ψ − …|, so that no angle need be unwound.
// (Involute function, base pitch, normal backlash b: ISO 21771-1:2007.) Closer than S there is no mesh: inv α stays 0.
#pragma once

#include <algorithm>
#include <cmath>

#include "dynamics/gap_motion.hpp"
#include "dynamics/kinematics.hpp"
#include "mechanism/mesh.hpp"

namespace freeplay {

/// A flank at one state.
template <class T>
struct FlankOf {
  T gap;                     ///< m
  Vec2Of<T> along;           ///< u, direction of the force on the second body
  T turn_i = 0, turn_j = 0;  ///< m, of ġ with ω_i and ω_j where ḋ is zero
};

/// Where a step is long enough for another tooth to come (speed: bound on |ġ|, m/s), the gap jumps by a period P unseen. From
/// play to play that is a way of P/2 at least, so pieces of dt = P/(4 speed) hold no jump: a bend of 64 speed²/P lets no longer
/// one be decided, for it takes P/2, all there is, off the chord, and changes a rate by 16 speed.
inline void heed_teeth(GapMotion& m, double period, double speed, double h) {
  if (std::isfinite(period) && speed * h > 0.25 * period)
    m.bend = std::max(m.bend, 64 * speed * speed / period);
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
      if (std::isfinite(period)) along -= T(period * std::round(value_of(along) / period));
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

  /// What of g̈ is neither u·d̈ nor of angular accelerations.
  template <class T>
  T bend(const FlankOf<T>& f, const Vec2Of<T>& d, const Vec2Of<T>& rate, const T&, const T&) const {
    using std::sqrt;
    const T L2 = dot(d, d) - sum() * sum(), across = cross(f.along, rate);
    return L2 > 0 ? T(kind * across * across / sqrt(L2)) : T(0);
  }

  /// How the gap may bend within a step; d at its end.
  GapMotion motion(const Link& link, const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    const double S = sum(), near = d.norm() - m.speed * bounds.duration;
    if (m.speed > 0) m.bend += near > S ? m.speed * m.speed / std::sqrt(near * near - S * S) : INFINITY;
    double speed = m.speed;
    for (const auto& [body, R] : {std::pair{link.i, Ri}, std::pair{link.j, Rj}})
      if (body != ground) {
        m.bend += std::abs(R) * bounds.acceleration[planar::first(body) + 2];
        speed += std::abs(R) * bounds.speed[planar::first(body) + 2];
      }
    heed_teeth(m, period, speed, bounds.duration);
    return m;
  }
};

}  // namespace freeplay
