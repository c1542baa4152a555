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

#include <vector>

#include "mechanism/cam_profile.hpp"
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

}  // namespace freeplay
