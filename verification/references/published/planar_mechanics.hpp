// Four examples of the Modelica library PlanarMechanics, with gravity g = 9.81 m/s² along −y:
//
// Piston engine: a crank of inertia J about its pin moves a slider of mass m along x by a massless
// rod. Its energy ½ J ω² + ½ m ẋ² is constant, since nothing with mass changes its height.
//
// Crane crab: a cart of 1 kg on a horizontal guide with a damper of 10 N s/m, and a body of 0.5 kg
// and 0.1 kg m² on a massless arm of 1 m, released at 150° from the hanging position.
//
// Double pendulum: bodies of 1 kg, 0.1 kg m² and 0.2 kg, 0.01 kg m² at the ends of massless arms of
// 1 m and 0.4 m, released at rest in horizontal position.
//
// Kinematic loop: two massless arms of 0.5 m join a knee to the origin and to a slider on the x
// axis, which is massless in the source and has 1e-6 kg here and in the scene. A spring (20 N/m,
// 0.4 m) and a damper (4 N s/m) act between origin and slider, whose place is s = 2 · 0.5 sin φ₁. A
// body of 1 kg and 0.1 kg m² hangs from the knee on an arm of 0.6 m.
//
// Units: m, kg, s, rad. Sign convention: angles counter-clockwise; of the second joint of a chain
// relative to the first. Source: PlanarMechanics/Examples/*.mo (github.com/dzimmer/PlanarMechanics,
// D. Zimmer, DLR); stored results of library version 1.6.0 by Dymola 2023x, DASSL, tolerance 1e-6:
// github.com/DLR-SR/PlanarMechanics_ReferenceResults. Equations by hand.
#pragma once

#include "verification/references/published/smooth_motion.hpp"

namespace freeplay::reference {

inline constexpr long double planar_mechanics_gravity = 9.81L;

/// φ, ω of the crank.
struct PistonEngine {
  using State = std::array<long double, 2>;
  long double crank = 0.3L, rod = 0.8L, inertia = 0.1L, mass = 3;

  State rates(const State& y) const {
    const long double s = crank * std::sin(y[0]), c = crank * std::cos(y[0]),
                      cosine = std::sqrt(rod * rod - s * s);
    // x = r cos φ + √(l² − r² sin² φ) and its derivatives by φ
    const long double slope = -s - s * c / cosine,
                      bend = -c - (c * c - s * s) / cosine - s * s * c * c / (cosine * cosine * cosine);
    return {y[1], -mass * slope * bend * y[1] * y[1] / (inertia + mass * slope * slope)};
  }
  State at(long double t, int steps = 8000) const {
    return smooth_motion([this](long double, const State& y) { return rates(y); }, State{0, -2.5L}, t, steps);
  }
};

/// s, φ, ṡ, φ̇.
struct CraneCrab {
  using State = std::array<long double, 4>;
  static State rates(const State& y) {
    const Plane arm = -perpendicular * direction(y[1]), weight = -perpendicular * planar_mechanics_gravity;
    VirtualWork<2> work;
    work.mass(1, {1, 0}, 0, -10 * y[2]);
    work.mass(0.5L, {1, perpendicular * arm}, -y[3] * y[3] * arm, 0.5L * weight);
    work.rotation(0.1L, {0, 1}, 0, 0);
    const auto a = work.accelerations();
    return {y[2], y[3], a[0], a[1]};
  }
  static State at(long double t, int steps = 8000) {
    const State start{0, 2.6179938779915L, 0, 0};
    return smooth_motion([](long double, const State& y) { return rates(y); }, start, t, steps);
  }
};

/// φ₁, φ₂, φ̇₁, φ̇₂.
struct DoublePendulumOfModelica {
  using State = std::array<long double, 4>;
  static State rates(const State& y) {
    const Plane one = direction(y[0]), two = 0.4L * direction(y[0] + y[1]), i = perpendicular,
                weight = -i * planar_mechanics_gravity;
    const long double turn = y[2] + y[3];
    VirtualWork<2> work;
    work.mass(1, {i * one, 0}, -y[2] * y[2] * one, weight);
    work.rotation(0.1L, {1, 0}, 0, 0);
    work.mass(0.2L, {i * (one + two), i * two}, -y[2] * y[2] * one - turn * turn * two, 0.2L * weight);
    work.rotation(0.01L, {1, 1}, 0, 0);
    const auto a = work.accelerations();
    return {y[2], y[3], a[0], a[1]};
  }
  static State at(long double t, int steps = 16000) {
    return smooth_motion([](long double, const State& y) { return rates(y); }, State{}, t, steps);
  }
};

/// φ₁, φ₄, φ̇₁, φ̇₄.
struct KinematicLoop {
  using State = std::array<long double, 4>;
  long double slider = 1e-6L;

  State rates(const State& y) const {
    const Plane i = perpendicular, knee = -0.5L * i * direction(y[0]),
                hung = -0.6L * i * direction(y[0] + y[1]), weight = -i * planar_mechanics_gravity;
    const long double turn = y[2] + y[3], place = std::sin(y[0]), slope = std::cos(y[0]);
    VirtualWork<2> work;
    work.mass(1, {i * (knee + hung), i * hung}, -y[2] * y[2] * knee - turn * turn * hung, weight);
    work.rotation(0.1L, {1, 1}, 0, 0);
    work.mass(slider, {slope, 0}, -y[2] * y[2] * place, 0);
    work.force(0, -slope * (20 * (place - 0.4L) + 4 * slope * y[2]));
    const auto a = work.accelerations();
    return {y[2], y[3], a[0], a[1]};
  }
  State at(long double t, int steps = 6000) const {
    const State start{std::asin(0.4L), -0.69813170079773L, 0, 0};
    return smooth_motion([this](long double, const State& y) { return rates(y); }, start, t, steps);
  }
};

/// Stored results: crank angle and rate at 10 s; cart's place, body's angle and rates at 10 s;
/// angles and rates of the pendulum at 10 s and of the loop at 6 s.
inline constexpr std::array<double, 2> modelica_piston_engine{-16.814939496173498, -1.5942662794413873};
inline constexpr std::array<double, 4> modelica_crane_crab{-0.022500227083739884, 0.63438290867220337,
                                                           0.1926889597016514, -0.15900647174341664};
inline constexpr std::array<double, 4> modelica_kinematic_loop{0.31854238765371756, -0.26874002529911167,
                                                               0.075377524585935343, 0.42138005465205353};

}  // namespace freeplay::reference
