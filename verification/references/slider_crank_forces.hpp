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
#pragma once

#include "verification/references/planar.hpp"
#include "verification/references/slider_crank.hpp"

namespace freeplay::reference {

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
