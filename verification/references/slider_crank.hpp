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

#include "verification/references/planar.hpp"

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

// Forces in the ideal in-line slider-crank at constant crank speed ω, by Newton–Euler. Shaft at the
// origin, guide along x, crank angle φ from the x axis; motion from slider_crank.hpp.
//
//     e = (cos φ, sin φ),  u = (cos θ, sin θ),  u′ = (−sin θ, cos θ)
//     crank        pin A = r e,              centre of mass C = a e,        Ä = −ω² A,   C̈ = −ω² C
//     rod          centre G = A + b u,       G̈ = −ω² A + b (θ̈ u′ − θ̇² u)
//     slider       pin B = A + l u = (x, 0), centre of mass at B + c, c constant,
//                  ẍ along the guide
//
// One body after the other, from the far end:
//
//     slider, x              B_x = M ẍ − M g_x − P_x
//     rod, moments about A   l u × (−F_B) + b u × m g = J θ̈ + b u × m G̈
//                            B_y = [B_x sin θ + (m b u × (g − G̈) − J θ̈)/l] / cos θ
//     slider, y              N = −(M g_y + P_y) − B_y
//     slider, moments at B   M_N = c × (M (ẍ, 0) − M g − P)              zero for c = 0
//     rod                    F_A = F_B + m (G̈ − g)
//     crank                  F_O = F_A + m_c (C̈ − g)
//     crank, moments at O    τ = A × F_A − C × m_c g                     no inertia: ω is constant
//
// Sign convention: world axes; angles, rates, moments and torques counter-clockwise; φ = 0 at top
// dead centre (x = r + l). F_A is the force of the crank on the rod at the crank pin, F_B = (B_x,
// B_y) that of the rod on the slider at the gudgeon pin, N that of the guide on the slider (along
// y) and M_N its moment about the gudgeon pin, F_O the force of the ground on the crank at the
// shaft, τ the torque of the drive on the crank. The opposite forces act on the bodies on the other
// side. g is the acceleration of gravity, (0, −9.81) where it points down; the load P acts on the
// slider at its centre of mass. No friction. Units: m, kg, s, rad, N.
// Source: Newton–Euler as above; e.g. Norton, Design of Machinery, on the dynamics of engines.

template <class Real>
struct LoadedSliderCrank {
  Real crank_length = 0;  ///< r, m, in (0, l)
  Real rod_length = 0;    ///< l, m
  Real crank_mass = 0;    ///< m_c, kg
  /// a, m, from the shaft towards the pin; 0: balanced, < 0: counterweight
  Real crank_centre = 0;
  Real crank_inertia = 0;        ///< kg m²; without effect at constant speed, kept for energies
  Real rod_mass = 0;             ///< m, kg
  Real rod_centre = 0;           ///< b, m, from the crank pin towards the gudgeon pin
  Real rod_inertia = 0;          ///< J, kg m², about its centre of mass
  Real slider_mass = 0;          ///< M, kg
  Planar<Real> slider_centre{};  ///< c, m, from the gudgeon pin
  Planar<Real> gravity{};        ///< g, m/s²
  Planar<Real> load{};           ///< P, N, on the slider at its centre of mass
  Real speed = 0;                ///< ω, rad/s, either sign or zero
};

template <class Real>
struct SliderCrankForces {
  SliderCrankMotion<Real> motion;  ///< of rod and slider
  Planar<Real> crank_on_rod;       ///< F_A, N
  Planar<Real> rod_on_slider;      ///< F_B, N
  JointLoad<Real> guide;           ///< (0, N) and M_N, on the slider, about the gudgeon pin
  Planar<Real> ground_on_crank;    ///< F_O, N
  Real torque = 0;                 ///< τ, N m, of the drive on the crank
};

/// Motion and forces at the crank angle φ (rad).
template <class Real>
SliderCrankForces<Real> slider_crank_forces(const LoadedSliderCrank<Real>& s, Real angle) {
  SliderCrankForces<Real> f;
  f.motion = slider_crank(s.crank_length, s.rod_length, angle, s.speed);
  const SliderCrankMotion<Real>& k = f.motion;
  const Planar<Real> e = direction(angle), u = direction(k.rod_angle), g = s.gravity;
  const Real w2 = s.speed * s.speed;
  const Planar<Real> pin = s.crank_length * e, centre = s.crank_centre * e;
  const Planar<Real> rod_acceleration =
      -w2 * pin + s.rod_centre * (k.rod_acceleration * quarter_turn(u) - k.rod_rate * k.rod_rate * u);

  const Real b_x = s.slider_mass * (k.acceleration - g.x) - s.load.x;
  const Real turning =
      s.rod_mass * s.rod_centre * cross(u, g - rod_acceleration) - s.rod_inertia * k.rod_acceleration;
  const Real b_y = (b_x * u.y + turning / s.rod_length) / u.x;
  f.rod_on_slider = {b_x, b_y};
  f.guide.force = {0, -(s.slider_mass * g.y + s.load.y) - b_y};
  const Planar<Real> slider_acceleration{k.acceleration, 0};
  f.guide.moment = cross(s.slider_centre, s.slider_mass * (slider_acceleration - g) - s.load);
  f.crank_on_rod = f.rod_on_slider + s.rod_mass * (rod_acceleration - g);
  f.ground_on_crank = f.crank_on_rod + s.crank_mass * (-w2 * centre - g);
  f.torque = cross(pin, f.crank_on_rod) - s.crank_mass * cross(centre, g);
  return f;
}

}  // namespace freeplay::reference
