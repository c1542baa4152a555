// Contact pairs of cams: their pitch curve (PitchCurve), flat follower (CamFlatPair), roller (CamRollerPair).
//
// The closed curve p(φ) = r(φ) e(φ), r = offset + h(φ), of a cam profile in polar form, and its
// nearest point to a point c. With ρ = |c|, half the squared distance and its derivatives are
//
//     F = ½|c − p|²,   F' = −(c − p)·p',   F'' = |p'|² − (c − p)·p''
//
// Newton's method from the polar angle of c finds a stationary point of F, which may be another one
// than the nearest on a curve with hollows. The nearest point is proved in two stages:
//
// 1. Let D₀ be the distance to the point at the polar angle. Nearer points lie within the angle Δ of
//    it, D₀² ≥ (ρ − r)² + 2ρ r (1 − cos Δ). If bounds of |h'| and |h''| show F'' > 0 up to Δ, F has
//    one minimum there. Near the curve this always holds.
// 2. Otherwise the pieces of the profile are visited on both sides of the polar angle until bounds of
//    r exclude all farther ones. Each is divided until bounds of F and F' exclude an interval, or
//    F'' > 0 holds in it and Newton's method ends in its only minimum (interval Newton method: Moore,
//    Kearfott, Cloud, Introduction to Interval Analysis, 2009, ch. 8 and 9).
//
// No state is kept, so the point depends on c alone. A star-shaped curve has a unique nearest point to
// every outer point nearer than the least radius of curvature of its concave places: outer double
// normals, at which two points would face each other across a gap, do not exist.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "dynamics/pairs.hpp"
#include "mechanism/cam_profile.hpp"
#include "numerics/choice.hpp"
#include "values/vec2.hpp"

namespace freeplay {

class PitchCurve {
 public:
  /// A point of the curve and the distance from it to c.
  struct Place {
    double phi;                ///< rad
    CamProfile::Value lift;    ///< h and its derivatives
    Vec2 radial;               ///< e
    Vec2 slope, curl;          ///< p', p''
    Vec2 away;                 ///< m, c − p
    double half_square, rate;  ///< F (m²), F' (m²/rad)
    double bend;               ///< F'' (m²/rad²)

    /// m, distance of c along the outward normal; exact at the nearest point.
    double gap() const { return cross(away, slope) / slope.norm(); }
  };

  PitchCurve(double offset, CamProfile profile);
  /// The nearest point to c.
  Place nearest(const Vec2& c) const;
  /// m, polar radius without lift
  double offset() const { return offset_; }
  /// The lift.
  const CamProfile& profile() const { return profile_; }

 private:
  struct Search;
  /// A piece of the profile, with bounds on it.
  struct Sector {
    double begin, end, spacing;  ///< rad; spacing of samples
    Vec2 first, last;            ///< e at its ends
    double low, high;            ///< m, bounds of r
    double d1, d2, d3;           ///< bounds of |h'|, |h''| and |h'''|
  };
  Place look(const Vec2& c, double phi, const Vec2& radial) const;
  Place descend(const Vec2& c, const Place& from, double a, double b) const;
  bool only_minimum(double rho, double half_square, double& delta) const;

  double offset_, low_ = 0, high_ = 0;
  CamProfile profile_;
  std::vector<Sector> sectors_;
};

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
    m.acceleration += 2 * turn * m.speed + (turn * turn + twist) * reach;
    m.shape = GapMotion::Shape::curved;
    m.acceleration += profile.bounds().d1 * more + profile.bounds().d2 * relative * relative;
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
    const auto y = profile.at(psi);
    const T H = base_radius + y.h, H1 = y.d1, H2 = y.d2;
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
// The nearest point is that of the whole curve (PitchCurve). It is unique, and these
// derivatives hold, while g is less than the least radius of curvature of concave places. Farther
// away the nearest point may change, and ġ drops there.

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
    m.acceleration += twist * reach + 2 * turn * w + turn * turn * reach;
    m.shape = GapMotion::Shape::curved;
    m.speed = w;
    m.reach = 0.5 * least_hollow;
    m.acceleration += w * w * std::max(1 / least_round, 2 / least_hollow);
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
    const auto [r, r1, r2, co, si] = nearest(c);
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
  /// r, r′, r″ and e at the nearest point.
  template <class T>
  struct Nearest {
    T r, r1, r2, co, si;
  };
  Nearest<double> nearest(const Vec2& c) const {
    const auto p = curve.nearest(c);
    return {curve.offset() + p.lift.h, p.lift.d1, p.lift.d2, p.radial.x(), p.radial.y()};
  }
  /// Its derivatives are those of one Newton step. At a centre of curvature, where F'' = 0, it has none.
  Nearest<Traced> nearest(const Vec2Of<Traced>& c) const {
    const auto found = [curve = curve](const double* x, double* y) {
      const auto p = curve.nearest({x[0], x[1]});
      const double bend = std::max(p.bend, 1e-12 * dot(p.slope, p.slope));
      const double list[] = {x[0],      x[1],      p.slope.x() / bend, p.slope.y() / bend, p.lift.h,
                             p.lift.d1, p.lift.d2, p.lift.d3,          p.radial.x(),       p.radial.y()};
      std::ranges::copy(list, y);
    };
    const auto y = call_outside({10, found}, std::array{c.x(), c.y()}, "a place is found by iteration");
    const Traced turn = (c.x() - y[0]) * y[2] + (c.y() - y[1]) * y[3];
    return {curve.offset() + (y[4] + y[5] * turn), y[5] + y[6] * turn, y[6] + y[7] * turn, y[8] - y[9] * turn,
            y[9] + y[8] * turn};
  }
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
