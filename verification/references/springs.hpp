// One mass on one spring, in closed form. x is the extension (m), m the mass (kg), ω² = k/m.
//
//     Duffing     m ẍ + k x + c x³ = 0 from rest at A:  x = A cn(Ω t, κ),  Ω² = (k + c A²)/m,
//                 κ² = c A²/(2 (k + c A²))
//     cable       taut for x > 0 alone, no weight: half a period π/ω taut, and back
//                 with the initial speed
//     throw       ẍ = −g − ω² x while taut, from x = 0 with the speed u:
//                 slack again after (2/ω) atan(u ω/g), with −u
//     two rates   ω₁ where x < 0, ω₂ where x > 0: a period of π/ω₁ + π/ω₂
//     damped      m ẍ + d ẋ + k x = 0 from rest at A:  x = A e^(−δt) (cos νt + (δ/ν) sin νt),
//                 δ = d/2m,  ν² = ω² − δ²
//
// Source: Nayfeh and Mook, Nonlinear Oscillations (1979), sec. 2.1 (Duffing); the others are
// elementary.
#pragma once

#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>

namespace freeplay::reference {

/// x (m) at t (s).
inline double duffing(double mass, double k, double c, double A, double t) {
  const double rate = std::sqrt((k + c * A * A) / mass);
  const double modulus = std::sqrt(c * A * A / (2 * (k + c * A * A)));
  return A * boost::math::jacobi_cn(modulus, rate * t);
}

/// Position (m) of a mass that flies between two ends a cable's length from its anchor, starting
/// from the anchor with speed v.
inline double on_a_cable(double mass, double k, double length, double v, double t) {
  const double rate = std::sqrt(k / mass), taut = M_PI / rate, flight = 2 * length / v;
  double at = t - 0.5 * flight, side = 1;
  if (at < 0) return v * t;
  while (at > taut + flight) at -= taut + flight, side = -side;
  if (at < taut) return side * (length + v / rate * std::sin(rate * at));
  return side * (length - v * (at - taut));
}

/// Time (s) for which a cable with rate ω stays taut against a weight g.
inline double taut_in_throw(double u, double omega, double g) { return 2 / omega * std::atan(u * omega / g); }

/// x (m) at t (s).
inline double damped(double mass, double k, double d, double A, double t) {
  const double decay = 0.5 * d / mass, rate = std::sqrt(k / mass - decay * decay);
  return A * std::exp(-decay * t) * (std::cos(rate * t) + decay / rate * std::sin(rate * t));
}

}  // namespace freeplay::reference
