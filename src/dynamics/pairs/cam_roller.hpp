// A roller of radius R on body j and a cam on body i. The roller's centre is on the pitch curve
// when they touch. In polar form in the cam's frame this is p(φ) = r(φ) e(φ), r = base
// radius + R + h(φ). g is the distance of the centre from that curve along its outward normal u at
// the nearest point, τ = perp u, ρ the radius of curvature there (< 0: concave). With d = r_j − r_i
// and w = ḋ − ω_i perp d, the centre's velocity in the cam's frame,
//
//     g = u·(d − p),    ġ = u·w
//     g̈ = u·d̈ + α_i τ·d + 2 ω_i τ·w + ω_i² u·d + (τ·w)²/(ρ + g)
//     v_T = τ·w − R (ω_j − ω_i)
//     v̇_T = τ·d̈ − α_i u·d − 2 ω_i u·w + ω_i² τ·d − (τ·w)(u·w)/(ρ + g) − R (α_j − α_i)
//
// The nearest point is that of the whole curve (dynamics/pitch_curve.hpp). It is unique, and these
// derivatives hold, while g is less than the least radius of curvature of concave places. Farther
// away the nearest point may change, and ġ drops there.
#pragma once

#include <algorithm>
#include <cmath>

#include "dynamics/pairs/pair.hpp"
#include "dynamics/pitch_curve.hpp"

namespace freeplay {

struct CamRollerPair {
  Link link;
  double radius = 0;       ///< m, R
  double least_round = 0;  ///< m, least radius of curvature where the pitch curve is convex
  /// m, least radius where it is concave; infinite if it is nowhere concave
  double least_hollow = 0;
  PitchCurve curve;  ///< of radius base radius + R + h

  double gap(const Vec2& d, const Evaluation& e) const { return curve.nearest(in_cam(d, e)).gap(); }
  /// Bounds on the gap's second derivative within a step; d at its end.
  GapMotion motion(const MotionBounds& bounds, const Vec2& d) const {
    auto m = relative_motion(link, bounds);
    const double turn = omega(bounds.speed.data(), link.i), twist = omega(bounds.acceleration.data(), link.i);
    const double reach = d.norm() + m.speed * bounds.duration, w = m.speed + turn * reach;
    m.bend += twist * reach + 2 * turn * w + turn * turn * reach;
    m.shape = GapMotion::Shape::curved;
    m.speed = w;
    m.reach = 0.5 * least_hollow;
    m.bend += w * w * std::max(1 / least_round, 2 / least_hollow);
    return m;
  }
  /// Motion within a time h as a share of the motion that could pass the contact undetected: the
  /// narrowest rise or return of a turning cam, the diameter of the sharpest crest of the pitch curve.
  double passage(const double* v, double h) const {
    return std::max(std::abs(omega(v, link.i)) * h / curve.profile().narrowest(),
                    path(link, v, h) / (2 * least_round));
  }

  template <class T>
  void rows(const ContactFacts& facts, const Arms<T>& a, const T* v, const EvaluationOf<T>& e,
            ContactRowOf<T>& row) const {
    const int i = link.i, j = link.j;
    const Vec2Of<T> c = in_cam(a.d, e);
    const auto p = curve.nearest({value_of(c.x()), value_of(c.y())});
    // Derivatives of the nearest point: one Newton step with those of c. At a centre of curvature,
    // where F'' = 0, it has none.
    const T off = (c.x() - value_of(c.x())) * p.slope.x() + (c.y() - value_of(c.y())) * p.slope.y();
    const T phi = p.phi + off / std::max(p.bend, 1e-12 * dot(p.slope, p.slope));
    const auto& y = p.lift;
    const T r = curve.offset() + lifted(phi, y.h, y.d1), r1 = lifted(phi, y.d1, y.d2),
            r2 = lifted(phi, y.d2, y.d3);
    const T co = lifted(phi, p.radial.x(), -p.radial.y()), si = lifted(phi, p.radial.y(), p.radial.x());
    const Vec2Of<T> radial{co, si}, round{-si, co};
    const Vec2Of<T> slope{r1 * radial.x() + r * round.x(), r1 * radial.y() + r * round.y()};
    const T square = slope.squared_norm(), length = slope.norm();
    const T rho = square * length / (r * r + 2 * r1 * r1 - r * r2);
    // Back to the world: u, and the tangent counterclockwise around the cam.
    const Vec2Of<T> tau = in_world(Vec2Of<T>{slope.x() / length, slope.y() / length}, e), u = -perp(tau);
    row.gap = ((c.x() - r * co) * slope.y() - (c.y() - r * si) * slope.x()) / length;

    const T wi = omega(v, i), wj = omega(v, j), height = dot(u, a.d), along = dot(tau, a.d);
    const Vec2Of<T> rate = relative_velocity(link, a, v);
    const T closing = dot(u, rate) + wi * along, slide = dot(tau, rate) - wi * height;
    const T swirl = slide / (rho + row.gap);
    const Vec2Of<T> still = centripetal(a.ri, wi, a.rj, wj), back = -u;
    row.gamma_n = -(dot(u, still) + 2 * wi * slide + wi * wi * height + swirl * slide);
    push(row.normal, i, back, T(cross(a.ri, back) + along));
    push(row.normal, j, u, cross(a.rj, u));
    if (!facts.surface.friction) return;
    row.gamma_t = -(dot(tau, still) - 2 * wi * closing + wi * wi * along - swirl * closing);
    const Vec2Of<T> behind = -tau;
    push(row.tangent, i, behind, T(cross(a.ri, behind) - (height - radius)));
    push(row.tangent, j, tau, T(cross(a.rj, tau) - radius));
  }

 private:
  template <class T>
  Vec2Of<T> in_cam(const Vec2Of<T>& d, const EvaluationOf<T>& e) const {
    if (link.i == ground) return d;
    const T &c = e.cosine[link.i], &s = e.sine[link.i];
    return {c * d.x() + s * d.y(), c * d.y() - s * d.x()};
  }
  template <class T>
  Vec2Of<T> in_world(const Vec2Of<T>& d, const EvaluationOf<T>& e) const {
    if (link.i == ground) return d;
    const T &c = e.cosine[link.i], &s = e.sine[link.i];
    return {c * d.x() - s * d.y(), s * d.x() + c * d.y()};
  }
};

}  // namespace freeplay
