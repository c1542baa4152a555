// A flat face of body j on a cam of body i. The cam's outline is the envelope of its tangents. Its
// support function in the direction u, at the angle ψ in the cam's frame, is H(ψ) = base
// radius + h(ψ) from the cam's point; the tangent point is H u + H' τ, τ = perp u. The free side of
// the face is towards −u. With d = r_j − r_i
//
//     g = u·d − H(ψ),      ġ = u·ḋ + ω_j τ·d − H' (ω_j − ω_i)
//     g̈ = u·d̈ + 2 ω_j τ·ḋ + α_j τ·d − ω_j² u·d − H' (α_j − α_i) − H'' (ω_j − ω_i)²
//     v_T = τ·ḋ − ω_j g − ω_i H
//     v̇_T = τ·d̈ − ω_j (u·ḋ + ġ) − α_j g − α_i H − ω_i H' (ω_j − ω_i)
//
// This is exact for every convex outline, H + H'' > 0.
#pragma once

#include <cmath>

#include "dynamics/pairs/pair.hpp"
#include "mechanism/cam_profile.hpp"
#include "numerics/choice.hpp"

namespace freeplay {

struct CamFlatPair {
  Link link;
  Vec2 axis{1, 0};         ///< along the face, in body j's frame; the cam is on its left
  double base_radius = 0;  ///< m
  CamProfile profile;

  /// u·d − H, with the angle ψ of u in the cam's frame.
  double gap(const Vec2& d, const Evaluation& e) const {
    const Vec2 u = -perp(turned(link.j, axis, e));
    return dot(u, d) - (base_radius + profile.at(angle_in_cam(u, e)).h);
  }
  /// Bounds on the gap's second derivative within a step; d at its end.
  GapMotion motion(const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    const auto of = [](const std::vector<double>& x, int body) { return omega(x.data(), body); };
    const double turn = of(bounds.speed, link.j), twist = of(bounds.acceleration, link.j);
    const double relative = of(bounds.speed, link.i) + turn, more = of(bounds.acceleration, link.i) + twist;
    const double reach = d.norm() + m.speed * bounds.duration;
    m.bend += 2 * turn * m.speed + (turn * turn + twist) * reach;
    m.shape = GapMotion::Shape::curved;
    m.bend += profile.bounds().d1 * more + profile.bounds().d2 * relative * relative;
    return m;
  }
  /// Rotation within a time h, as a share of the narrowest rise or return.
  double passage(const double* v, double h) const {
    return std::abs(omega(v, link.j) - omega(v, link.i)) * h / profile.narrowest();
  }

  template <class T>
  void rows(const ContactFacts& facts, const Arms<T>& a, const T* v, const EvaluationOf<T>& e,
            ContactRowOf<T>& row) const {
    const int i = link.i, j = link.j;
    const Vec2Of<T> tau = turned(j, axis, e), u = -perp(tau);
    const T psi = angle_in_cam(u, e);
    const auto y = profile.at(place_of(psi));
    const T H = base_radius + lifted(psi, y.h, y.d1), H1 = lifted(psi, y.d1, y.d2),
            H2 = lifted(psi, y.d2, y.d3);
    const Vec2Of<T> rate = relative_velocity(link, a, v);
    const T wi = omega(v, i), wj = omega(v, j), w = wj - wi, height = dot(u, a.d), along = dot(tau, a.d);
    const Vec2Of<T> still = centripetal(a.ri, wi, a.rj, wj), back = -u;
    row.gap = height - H;
    row.gamma_n = wj * wj * height + H2 * w * w - 2 * wj * dot(tau, rate) - dot(u, still);
    push(row.normal, i, back, T(cross(a.ri, back) + H1));
    push(row.normal, j, u, T(cross(a.rj, u) + along - H1));
    if (!facts.surface.friction) return;
    const T closing = dot(u, rate) + wj * along - H1 * w;
    row.gamma_t = wj * (dot(u, rate) + closing) + wi * H1 * w - dot(tau, still);
    const Vec2Of<T> behind = -tau;
    push(row.tangent, i, behind, T(cross(a.ri, behind) - H));
    push(row.tangent, j, tau, T(cross(a.rj, tau) - row.gap));
  }

 private:
  template <class T>
  T angle_in_cam(const Vec2Of<T>& u, const EvaluationOf<T>& e) const {
    using std::atan2;
    if (link.i == ground) return atan2(u.y(), u.x());
    const T &c = e.cosine[link.i], &s = e.sine[link.i];
    return atan2(T(c * u.y() - s * u.x()), T(c * u.x() + s * u.y()));
  }
};

}  // namespace freeplay
