// Equations of motion in minimal coordinates by virtual work, and their integration in long double.
// Used by the references of published cases without contact. A body with the velocity v = Σ_j J_j
// q̇_j and the angular velocity ω = Σ_j w_j q̇_j has the acceleration Σ_j J_j q̈_j + b and the
// angular acceleration Σ_j w_j q̈_j + c. The principle of d'Alembert,
//
//     Σ_bodies [J_i · (m a − F) + w_i (I α − T)] = 0        for each coordinate i,
//
// gives linear equations for q̈. They are integrated in equal steps of the method of order 8 of
// Cooper and Verner; a run with twice the steps shows the error. Vectors are complex numbers.
// Units: m, kg, s, rad. Source: derived by hand.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <utility>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

using Plane = std::complex<long double>;
inline constexpr Plane perpendicular{0, 1};

inline Plane direction(long double angle) { return std::polar(1.0L, angle); }
inline long double dot(Plane a, Plane b) { return a.real() * b.real() + a.imag() * b.imag(); }

template <std::size_t N>
class VirtualWork {
 public:
  using Reals = std::array<long double, N>;

  /// A mass with the Jacobian `j`, the acceleration `bias` at q̈ = 0 and the force on it.
  void mass(long double m, const std::array<Plane, N>& j, Plane bias, Plane force) {
    for (std::size_t r = 0; r < N; ++r) {
      for (std::size_t c = 0; c < N; ++c) matrix_[r][c] += m * dot(j[r], j[c]);
      right_[r] += dot(j[r], force - m * bias);
    }
  }
  /// The rotation of a body with the moment of inertia `inertia` and the torque on it.
  void rotation(long double inertia, const Reals& w, long double bias, long double torque) {
    for (std::size_t r = 0; r < N; ++r) {
      for (std::size_t c = 0; c < N; ++c) matrix_[r][c] += inertia * w[r] * w[c];
      right_[r] += w[r] * (torque - inertia * bias);
    }
  }
  /// A force on a coordinate.
  void force(std::size_t coordinate, long double value) { right_[coordinate] += value; }

  /// q̈, by Gaussian elimination; the matrix is symmetric and positive definite.
  Reals accelerations() const {
    auto a = matrix_;
    Reals b = right_;
    eliminate(a, b, Pivots::none);
    return b;
  }

 private:
  std::array<Reals, N> matrix_{};
  Reals right_{};
};

/// The state at `end` of ẏ = f(t, y) with y at t = 0.
template <std::size_t N, class Rate>
std::array<long double, N> smooth_motion(const Rate& f, std::array<long double, N> y, long double end,
                                         int steps) {
  static const CooperVerner<long double> method;
  const long double h = end / steps;
  for (int i = 0; i < steps; ++i) y = method.step(f, static_cast<long double>(i) * h, y, h);
  return y;
}

/// Real p and q with a p + b q = v.
inline std::pair<long double, long double> components(Plane a, Plane b, Plane v) {
  const long double det = a.real() * b.imag() - a.imag() * b.real();
  return {(v.real() * b.imag() - v.imag() * b.real()) / det,
          (a.real() * v.imag() - a.imag() * v.real()) / det};
}

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
