// Two circles. With e = r_j − r_i, n = e/|e|, t = perp n. A journal inside a bearing has s = +1 and
// touches at |e| = R_i − R_j. Discs outside each other have s = −1 and are described with R_j < 0:
//
//     g = s(R_i − R_j − |e|),    ġ = −s n·ė,         g̈ = −s[n·ë + (t·ė)²/|e|]
//     v_T = t·ė + R_j ω_j − R_i ω_i   (velocity of the second surface relative to the first)
//     v̇_T = t·ë − (t·ė)(n·ė)/|e| + R_j α_j − R_i α_i
//
// and for films
//
//     w_t = t·ė − ½(ω_i + ω_j)|e|
//     ẇ_t = t·ë − (t·ė)(n·ė)/|e| − ½(α_i + α_j)|e| − ½(ω_i + ω_j) n·ė
#pragma once

#include "dynamics/pairs/pair.hpp"

namespace freeplay {

struct RoundPair {
  Link link;
  double side = 1;                    ///< s: +1 ring, −1 discs
  double rest = 0;                    ///< m, |e| at contact
  double radius_i = 0, radius_j = 0;  ///< m; R_j < 0 for discs

  double gap(const Vec2& d, const Evaluation&) const { return side * (rest - d.norm()); }
  /// Bounds on the gap's second derivative within a step.
  GapMotion motion(const MotionBounds& bounds, const Vec2&) const {
    auto m = relative_motion(link, bounds);
    m.shape = side > 0 ? GapMotion::Shape::inside : GapMotion::Shape::outside;
    m.rest = rest;
    return m;
  }

  /// Motion within a time h as a share of the motion that could pass the contact undetected: twice
  /// the sum of the radii for discs. Zero for a journal, which stays outside its bearing's wall
  /// once it is there.
  double passage(const double* v, double h) const { return side > 0 ? 0 : path(link, v, h) / (2 * rest); }

  template <class T>
  void rows(const ContactFacts& facts, const Arms<T>& a, const T* v, const EvaluationOf<T>&,
            ContactRowOf<T>& row) const {
    using std::sqrt;
    const int i = link.i, j = link.j;
    const T length = sqrt(dot(a.d, a.d));
    row.gap = side * (rest - length);
    // A concentric journal has no normal. A film still resists it, equally in all directions, so
    // any normal is used.
    const bool concentric = !(length > 1e-9 * facts.clearance);
    if (concentric && !facts.lubricant) return;

    Vec2Of<T> n{T(1), T(0)};
    if (!concentric) n = {a.d.x() / length, a.d.y() / length};
    const Vec2Of<T> t = perp(n), rate = relative_velocity(link, a, v);
    const Vec2Of<T> still = centripetal(a.ri, omega(v, i), a.rj, omega(v, j));
    const T swirl = dot(t, rate);
    row.gamma_n = side * dot(n, still);
    if (!concentric) row.gamma_n += side * swirl * swirl / length;
    const Vec2Of<T> outward{side * n.x(), side * n.y()}, inward = -outward;
    push(row.normal, i, outward, cross(a.ri, outward));
    push(row.normal, j, inward, cross(a.rj, inward));
    const Vec2Of<T> back = -t;
    if (facts.lubricant) {
      push(row.film, i, back, T(cross(a.ri, back) - 0.5 * length));
      push(row.film, j, t, T(cross(a.rj, t) - 0.5 * length));
      if (i != ground) row.spin.push(3 * i + 2, -1);
      if (j != ground) row.spin.push(3 * j + 2, 1);
      row.gamma_film = 0.5 * (omega(v, i) + omega(v, j)) * dot(n, rate) - dot(t, still);
      row.turn = concentric ? T(0) : T(swirl / length);
      row.gamma_film += row.turn * dot(n, rate);
    }
    if (!facts.surface.friction) return;
    row.gamma_t = -dot(t, still);
    if (!concentric) row.gamma_t += swirl * dot(n, rate) / length;
    push(row.tangent, i, back, T(cross(a.ri, back) - radius_i));
    push(row.tangent, j, t, T(cross(a.rj, t) + radius_j));
  }
};

}  // namespace freeplay
