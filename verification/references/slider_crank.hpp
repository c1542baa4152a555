// Ideal slider-crank, exact (no two-term approximation). Crank pin r (cos φ, sin φ), slider (x, 0):
//
//     sin θ = −(r/l) sin φ                             rod angle θ from the x axis, |θ| < π/2
//     x = r cos φ + l cos θ
//     θ̇ = −(r/l) φ̇ cos φ / cos θ
//     ẋ = −r φ̇ sin φ − l θ̇ sin θ
//     θ̈ = [(r/l) φ̇² sin φ + θ̇² sin θ] / cos θ          for φ̈ = 0
//     ẍ = −r φ̇² cos φ − l (θ̈ sin θ + θ̇² cos θ)
//
// Sign convention: angles counter-clockwise, φ = 0 at top dead centre (x = r + l). Units: m, rad,
// s.
// Source: the loop closure r e^{iφ} + l e^{iθ} = x, differentiated twice; e.g. Norton, Design of
// Machinery.
#pragma once

#include <cmath>
#include <stdexcept>

namespace freeplay::reference {

template <class Real = double>
struct SliderCrankMotion {
  Real x = 0;                 ///< m, slider position
  Real velocity = 0;          ///< m/s
  Real acceleration = 0;      ///< m/s²
  Real rod_angle = 0;         ///< rad
  Real rod_rate = 0;          ///< rad/s
  Real rod_acceleration = 0;  ///< rad/s²
};

/// Motion at crank angle φ (rad) and constant crank rate φ̇ = speed (rad/s), crank length r and rod
/// length l (m), r < l.
template <class Real>
SliderCrankMotion<Real> slider_crank(Real r, Real l, Real angle, Real speed) {
  using std::asin, std::cos, std::sin, std::sqrt;
  if (!(r > 0 && l > r)) throw std::invalid_argument("slider_crank: need 0 < r < l");
  const Real sin_phi = sin(angle), cos_phi = cos(angle);
  const Real sin_theta = -r / l * sin_phi;
  const Real cos_theta = sqrt((1 - sin_theta) * (1 + sin_theta));
  SliderCrankMotion<Real> m;
  m.rod_angle = asin(sin_theta);
  m.rod_rate = -r / l * speed * cos_phi / cos_theta;
  m.rod_acceleration = (r / l * speed * speed * sin_phi + m.rod_rate * m.rod_rate * sin_theta) / cos_theta;
  m.x = r * cos_phi + l * cos_theta;
  m.velocity = -r * speed * sin_phi - l * m.rod_rate * sin_theta;
  m.acceleration = -r * speed * speed * cos_phi -
                   l * (m.rod_acceleration * sin_theta + m.rod_rate * m.rod_rate * cos_theta);
  return m;
}

/// Crank speed in rad/s.
template <class Real>
Real from_rpm(Real rpm) {
  using std::atan;
  return rpm * 8 * atan(Real(1)) / 60;
}

}  // namespace freeplay::reference
