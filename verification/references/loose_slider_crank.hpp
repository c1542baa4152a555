// The slider-crank with clearance in the gudgeon pin, in two coordinates derived by hand. The crank
// angle φ = φ₀ + ω t is prescribed, the guide constrains the slider's y = 0 and its rotation; θ of
// the rod and x of the slider are free.
//
//     crank pin           A = r (cos φ, sin φ),     Ȧ = r ω (−sin φ, cos φ),     Ä = −ω² A
//     rod                 u = (cos θ, sin θ),       u′ = (−sin θ, cos θ)
//     bearing centre      B = A + l u
//     eccentricity        e = (x, 0) − B,           ė = (ẋ, 0) − Ȧ − l θ̇ u′
//     contact frame       n = e/|e|,                t = n turned by +90°
//     gap                 g = c − |e|,              ġ = −n·ė           = w_Nθ θ̇ + w_Nx ẋ + n·Ȧ
//     sliding             R_j ω_j = 0,              v_T = t·ė − R_i θ̇   = w_Tθ θ̇ + w_Tx ẋ − t·Ȧ
//     rows                w_N = (l n·u′, −n_x),     w_T = (−l t·u′ − R_i, t_x)
//
// Rod: moments about the accelerated point A eliminate the crank's force. With the centre of mass
// at s u from A and J_A = J + m s², J_A θ̈ + m s (u × Ä) = Q_θ and u × Ä = −r ω² sin(φ − θ). So
//
//     J_A θ̈ = m s r ω² sin(φ − θ) + Q_θ,      M ẍ = Q_x,      (Q_θ, Q_x) = w_N F_N + w_T F_T
//
// (virtual power of the contact). In free flight ẋ is constant and ψ = φ − θ is a pendulum,
// ψ̈ = −(m s r ω²/J_A) sin ψ. The contact's Delassus matrix is D_ab = w_aθ w_bθ/J_A + w_ax w_bx/M.
//
// Sign convention: angles counter-clockwise, φ = 0 at top dead centre; e from bearing (rod) to
// journal (slider); F_N ≥ 0 pushes the journal along −n, F_T acts on the journal along t. Units: m,
// kg, s, rad, N.
// No gravity, no friction in the guide.
// Source: Newton–Euler as above; the rig is that of Flores et al., Nonlinear Dyn. 65 (2011) 383,
// table 1.
#pragma once

#include <array>
#include <cmath>

#include "verification/references/oblique_impact.hpp"
#include "verification/references/slider_crank.hpp"

namespace freeplay::reference {

template <class Real>
struct LooseSliderCrank {
  Real crank_length = Real(0.05L);   ///< r, m
  Real rod_length = Real(0.3L);      ///< l, m
  Real rod_mass = Real(1.13L);       ///< m, kg
  Real rod_inertia = Real(0.0153L);  ///< J, kg m², about its centre of mass
  /// s, m, from the crank pin; the paper does not state it
  Real rod_centre = Real(0.15L);
  Real slider_mass = Real(1.013L);         ///< M, kg
  Real clearance = Real(0.25e-3L);         ///< c, m, radial
  Real bearing_radius = Real(11.125e-3L);  ///< R_i, m; the journal has R_i − c
  Real speed = from_rpm(Real(200));        ///< ω, rad/s
  Real start_angle = 0;                    ///< φ₀, rad
  Real friction = 0;                       ///< μ, Coulomb

  Real rod_inertia_about_pin() const { return rod_inertia + rod_mass * rod_centre * rod_centre; }
};

/// θ, θ̇, x, ẋ and the impulses of the present contact, ∫ F_N dt and ∫ F_T dt (rad, m, s, N s).
template <class Real>
using LooseState = std::array<Real, 6>;

/// The ideal joint's configuration and velocities: journal centred.
template <class Real>
LooseState<Real> ideal_start(const LooseSliderCrank<Real>& m) {
  const SliderCrankMotion<Real> ideal = slider_crank(m.crank_length, m.rod_length, m.start_angle, m.speed);
  return {ideal.rod_angle, ideal.rod_rate, ideal.x, ideal.velocity, 0, 0};
}

/// Rates of the state under the contact force's generalised components Q_θ (N m) and Q_x (N).
template <class Real>
LooseState<Real> loose_rates(const LooseSliderCrank<Real>& m, Real t, const LooseState<Real>& y,
                             Real q_theta = 0, Real q_x = 0) {
  using std::sin;
  const Real phi = m.start_angle + m.speed * t;
  const Real drive = m.rod_mass * m.rod_centre * m.crank_length * m.speed * m.speed * sin(phi - y[0]);
  return {y[1], (drive + q_theta) / m.rod_inertia_about_pin(), y[3], q_x / m.slider_mass, 0, 0};
}

/// Position of the journal in the bearing. `room` = (c² − e·e)/(2c) has the sign of the gap, agrees
/// with it at the wall to first order and, unlike it, is smooth where the journal is centred.
template <class Real>
struct Eccentricity {
  Real e_x, e_y;        ///< m
  Real rate_x, rate_y;  ///< m/s
  Real room;            ///< m
  Real room_rate;       ///< m/s, −e·ė/c
};

template <class Real>
Eccentricity<Real> eccentricity(const LooseSliderCrank<Real>& m, Real t, const LooseState<Real>& y) {
  using std::cos, std::sin;
  const Real phi = m.start_angle + m.speed * t, r = m.crank_length, l = m.rod_length, c = m.clearance;
  const Real cos_phi = cos(phi), sin_phi = sin(phi), cos_theta = cos(y[0]), sin_theta = sin(y[0]);
  const Real e_x = y[2] - r * cos_phi - l * cos_theta, e_y = -r * sin_phi - l * sin_theta;
  const Real rate_x = y[3] + r * m.speed * sin_phi + l * y[1] * sin_theta;
  const Real rate_y = -r * m.speed * cos_phi - l * y[1] * cos_theta;
  return {e_x,
          e_y,
          rate_x,
          rate_y,
          (c * c - e_x * e_x - e_y * e_y) / (2 * c),
          -(e_x * rate_x + e_y * rate_y) / c};
}

/// The contact's frame: needs e ≠ 0.
template <class Real>
struct GudgeonContact {
  Real delta;                    ///< m, |e| − c
  Real u_n, u_t;                 ///< m/s, ġ and v_T
  std::array<Real, 2> w_n, w_t;  ///< rows over (θ̇, ẋ): m, 1
  Real drive_n, drive_t;         ///< m/s, the prescribed parts n·Ȧ and −t·Ȧ
  Delassus<Real> delassus;       ///< 1/kg
};

template <class Real>
GudgeonContact<Real> gudgeon_contact(const LooseSliderCrank<Real>& m, Real t, const LooseState<Real>& y) {
  using std::cos, std::sin, std::sqrt;
  const Eccentricity<Real> e = eccentricity(m, t, y);
  const Real length = sqrt(e.e_x * e.e_x + e.e_y * e.e_y), n_x = e.e_x / length, n_y = e.e_y / length;
  const Real phi = m.start_angle + m.speed * t, rw = m.crank_length * m.speed, l = m.rod_length;
  const Real a_x = -rw * sin(phi), a_y = rw * cos(phi), s = sin(y[0]), c = cos(y[0]);
  GudgeonContact<Real> k{};
  k.delta = length - m.clearance;
  k.w_n = {l * (-n_x * s + n_y * c), -n_x};
  k.w_t = {-l * (n_y * s + n_x * c) - m.bearing_radius, -n_y};
  k.drive_n = n_x * a_x + n_y * a_y;
  k.drive_t = n_y * a_x - n_x * a_y;
  k.u_n = k.w_n[0] * y[1] + k.w_n[1] * y[3] + k.drive_n;
  k.u_t = k.w_t[0] * y[1] + k.w_t[1] * y[3] + k.drive_t;
  const auto product = [&m](const std::array<Real, 2>& a, const std::array<Real, 2>& b) {
    return a[0] * b[0] / m.rod_inertia_about_pin() + a[1] * b[1] / m.slider_mass;
  };
  k.delassus = {product(k.w_n, k.w_n), product(k.w_n, k.w_t), product(k.w_t, k.w_t)};
  return k;
}

}  // namespace freeplay::reference
