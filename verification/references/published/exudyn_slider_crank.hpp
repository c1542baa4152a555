// Slider-crank of the Exudyn test suite, on the ground or on an elastic frame. A crank of length L₁
// and a rod of length L₂, thin bars, drive a slider in a guide of the frame. A torque M acts on the
// crank from t = 0, without reaction on the frame. The frame has springs k and dampers d to the
// ground in x, in y and in its angle. With the frame's position R and angle Θ and the crank's angle
// ψ in the frame, a body at p(ψ) with the angle a(ψ) in the frame has
//
//     r = R + e^{iΘ} p,         r̈ = R̈ + e^{iΘ} (i Θ̈ p + ψ̈ p′ + ψ̇² p″ + 2 i Θ̇ ψ̇ p′ − Θ̇² p)
//     α = Θ̈ + ψ̈ a′ + ψ̇² a″,    sin β = −(L₁/L₂) sin ψ,    the rod's angle β
//
// Sign convention: angles counter-clockwise; the slider's guide is the x axis of the frame. Units:
// m, kg, s, rad. Source: Exudyn, main/pythonDev/TestModels/sliderCrankFloatingTest.py
// (github.com/jgerstmayr/EXUDYN); its stored result is the sum of the slider's positions of both
// mechanisms at 0.3 s, by the generalised-α method (index 2, spectral radius 0.5) with h = 6e-5 s.
#pragma once

#include "verification/references/published/smooth_motion.hpp"

namespace freeplay::reference {

struct ExudynSliderCrank {
  using Real = long double;
  using State = std::array<Real, 8>;  ///< X, Y, Θ, ψ and their rates

  bool floating = false;
  Real crank = 0.1L, rod = 0.3L, crank_mass = 0.2L, rod_mass = 0.2L, slider_mass = 0.4L;
  Real slider_inertia = 0.4e-3L, frame_mass = 2, frame_inertia = 1, torque = 0.1L;
  Real stiffness = 5000, damping = 50;  ///< N/m and N s/m, and N m/rad and N m s/rad

  /// The rod's angle and the slider's place in the frame, with their derivatives by ψ.
  struct Loop {
    std::array<Real, 3> angle, place;
  };
  Loop loop(Real psi) const {
    const Real ratio = crank / rod, s = ratio * std::sin(psi), c = ratio * std::cos(psi);
    const Real cosine = std::sqrt(1 - s * s), slope = -c / cosine;
    const Real bend = (s - slope * slope * s) / cosine;
    return {{-std::asin(s), slope, bend},
            {crank * std::cos(psi) + rod * cosine, -crank * std::sin(psi) + rod * slope * s,
             -crank * std::cos(psi) + rod * (bend * s + slope * c)}};
  }
  State rates(const State& y) const {
    const Plane i = perpendicular, turn = direction(y[2]);
    const Real dtheta = y[6], dpsi = y[7];
    VirtualWork<4> work;
    const auto body = [&](Real m, Real inertia, Plane p, Plane p1, Plane p2, Real a1, Real a2, Real moment) {
      const Plane bias = dpsi * dpsi * p2 + 2.0L * dtheta * dpsi * i * p1 - dtheta * dtheta * p;
      work.mass(m, {1, i, turn * i * p, turn * p1}, turn * bias, 0);
      work.rotation(inertia, {0, 0, 1, a1}, a2 * dpsi * dpsi, moment);
    };
    const Plane arm = direction(y[3]) * crank / 2.0L;
    const auto [angle, place] = loop(y[3]);
    const Plane half = direction(angle[0]) * rod / 2.0L;
    body(crank_mass, crank_mass * crank * crank / 12, arm, i * arm, -arm, 1, 0, torque);
    body(rod_mass, rod_mass * rod * rod / 12, 2.0L * arm + half, 2.0L * i * arm + i * angle[1] * half,
         -2.0L * arm + (i * angle[2] - angle[1] * angle[1]) * half, angle[1], angle[2], 0);
    body(slider_mass, slider_inertia, place[0], place[1], place[2], 0, 0, 0);
    if (floating) {
      work.mass(frame_mass, {1, i, 0, 0}, 0, -stiffness * Plane(y[0], y[1]) - damping * Plane(y[4], y[5]));
      work.rotation(frame_inertia, {0, 0, 1, 0}, 0, -stiffness * y[2] - damping * y[6]);
    } else {  // a frame of infinite mass
      work.mass(1e30L, {1, i, 0, 0}, 0, 0);
      work.rotation(1e30L, {0, 0, 1, 0}, 0, 0);
    }
    const auto a = work.accelerations();
    return {y[4], y[5], y[6], y[7], a[0], a[1], a[2], a[3]};
  }
  State at(Real t, int steps = 3000) const {
    return smooth_motion([this](Real, const State& y) { return rates(y); }, State{}, t, steps);
  }
  /// Position of the slider in the world.
  Plane slider(const State& y) const { return Plane(y[0], y[1]) + direction(y[2]) * loop(y[3]).place[0]; }
  /// Its velocity along x.
  Real slider_velocity(const State& y) const {
    const auto place = loop(y[3]).place;
    return y[4] + (direction(y[2]) * (y[7] * place[1] + perpendicular * y[6] * place[0])).real();
  }
};

/// Stored result of the test: the sum of the x positions of both sliders at 0.3 s.
inline constexpr double exudyn_slider_crank_sum = 0.591649163378833;

}  // namespace freeplay::reference
