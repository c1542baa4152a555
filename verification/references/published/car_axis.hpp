// The car axis of the IVP test set. Two axle ends l and r of mass m = M ε²/2 are at the ends of a
// massless rod of length L. Springs of 1 N/m and natural length L₀ join them to the road at (0, 0)
// and b = (x_b, y_b), y_b = r sin ωt, x_b = √(L² − y_b²). The left end stays on the line through
// the origin perpendicular to b. The coordinates are the height s of the left end on this line and
// the angle θ of the rod; φ is the inclination of the road:
//
//     l = s n,   r = l + L u,       n = (−sin φ, cos φ),   u = (cos θ, sin θ),   sin φ = y_b/L
//     F = (L₀/|p| − 1) p − m g ŷ on an end at p from its point of the road,   g = 1 m/s²
//
// Sign convention: angles counter-clockwise from x. Units: m, kg, s, rad. Source: Mazzia and
// Magherini, Test Set for Initial Value Problem Solvers, release 2.4 (2008), problem caraxis;
// published solution at 3 s by GAMD in quadruple precision. It differs from this reference by 2e-13
// m and 5e-12 m/s; so does the same problem in Cartesian coordinates with multipliers, integrated
// by the same method, which agrees with this reference to 1e-16.
#pragma once

#include "verification/references/published/smooth_motion.hpp"

namespace freeplay::reference {

struct CarAxis {
  using Real = long double;
  using State = std::array<Real, 4>;  ///< s, θ, ṡ, θ̇

  Real mass = 5e-4L, length = 1, rest_length = 0.5L, amplitude = 0.1L, frequency = 10, gravity = 1;

  /// The inclination of the road, its rate and its acceleration.
  std::array<Real, 3> road(Real t) const {
    const Real y = amplitude / length * std::sin(frequency * t), x = std::sqrt(1 - y * y);
    const Real slope = amplitude / length * frequency * std::cos(frequency * t) / x;
    return {std::asin(y), slope, (slope * slope - frequency * frequency) * y / x};
  }
  State start() const { return {rest_length, 0, 0, 0}; }

  State rates(Real t, const State& now) const {
    const auto [s, theta, ds, dtheta] = now;
    const auto [phi, dphi, ddphi] = road(t);
    const Plane i = perpendicular, along = direction(phi), n = i * along, u = direction(theta);
    const Plane left = s * n, right = left + length * u - length * along;
    const auto force = [&](Plane arm) {
      return (rest_length / std::abs(arm) - 1) * arm - i * mass * gravity;
    };
    const Plane bias = 2 * ds * dphi * i * n + s * (ddphi * i - dphi * dphi) * n;
    VirtualWork<2> work;
    work.mass(mass, {n, 0}, bias, force(left));
    work.mass(mass, {n, length * i * u}, bias - length * dtheta * dtheta * u, force(right));
    const auto a = work.accelerations();
    return {ds, dtheta, a[0], a[1]};
  }
  State at(Real t, int steps = 6000) const {
    return smooth_motion([this](Real now, const State& y) { return rates(now, y); }, start(), t, steps);
  }
  /// x, y and θ of the rod's centre and their rates.
  std::array<double, 6> rod(Real t, const State& y) const {
    const auto [phi, dphi, ddphi] = road(t);
    const Plane i = perpendicular, n = i * direction(phi), half = length / 2 * direction(y[1]);
    const Plane place = y[0] * n + half, speed = y[2] * n + y[0] * dphi * i * n + y[3] * i * half;
    return {double(place.real()), double(place.imag()), double(y[1]),
            double(speed.real()), double(speed.imag()), double(y[3])};
  }
};

/// Published positions of the left and the right end at 3 s (x, y each), and their velocities.
inline constexpr std::array<double, 4> car_axis_places{0.0493455784275402809, 0.496989460230171154,
                                                       1.04174252488542152, 0.373911027265361257};
inline constexpr std::array<double, 4> car_axis_speeds{-0.0770583684040972358, 0.00744686658723778553,
                                                       0.0175568157537232222, 0.770341043779251976};

}  // namespace freeplay::reference
