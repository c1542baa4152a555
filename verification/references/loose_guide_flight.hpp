// Free flight of the slider-crank with clearance in the slider's guide (Flores, Leine, Glocker
// 2010), in two coordinates derived by hand. The crank (angle a) is free; the slider turns about a
// pin at its own centre, so it acts on the bars only as a mass at the rod's end. A double pendulum,
// u(a) = (cos a, sin a):
//
//     centres     l₁ u(a)/2,     l₁ u(a) + l₂ u(b)/2,     l₁ u(a) + l₂ u(b)
//     k = (m₂/2 + m₃) l₁ l₂,     M₁ = J₁ + (m₁/4 + m₂ + m₃) l₁²,     M₂ = J₂ + (m₂/4 + m₃) l₂²
//     M₁ ä + k cos(a − b) b̈ = −k sin(a − b) ḃ² − g (m₁/2 + m₂ + m₃) l₁ cos a
//     k cos(a − b) ä + M₂ b̈ =  k sin(a − b) ȧ² − g (m₂/2 + m₃) l₂ cos b
//
// Valid until a corner is in contact, |l₁ sin a + l₂ sin b| < c for a slider that does not turn.
// Sign convention: angles counter-clockwise from the guide's axis. Units: m, kg, s, rad.
// Source: Lagrange's equations; data of the paper, Multibody Syst. Dyn. 23 (2010) 165.
#pragma once

#include <array>
#include <cmath>

#include "verification/references/cooper_verner.hpp"

namespace freeplay::reference {

struct LooseGuide {
  long double l1 = 0.153L, l2 = 0.306L;               ///< m
  long double m1 = 0.038L, m2 = 0.038L, m3 = 0.076L;  ///< kg
  long double J1 = 7.4e-5L, J2 = 5.9e-4L, g = 9.81L;  ///< kg m², m/s²
  long double clearance = 1e-3L;                      ///< m, half the total clearance
};

using GuideState = std::array<long double, 4>;  ///< a, b, ȧ, ḃ
inline constexpr GuideState guide_start{0, 0, 150, -75};

inline GuideState guide_rates(const LooseGuide& m, const GuideState& y) {
  const long double k = (m.m2 / 2 + m.m3) * m.l1 * m.l2, c = std::cos(y[0] - y[1]), s = std::sin(y[0] - y[1]);
  const long double M1 = m.J1 + (m.m1 / 4 + m.m2 + m.m3) * m.l1 * m.l1;
  const long double M2 = m.J2 + (m.m2 / 4 + m.m3) * m.l2 * m.l2;
  const long double f1 = -k * s * y[3] * y[3] - m.g * (m.m1 / 2 + m.m2 + m.m3) * m.l1 * std::cos(y[0]);
  const long double f2 = k * s * y[2] * y[2] - m.g * (m.m2 / 2 + m.m3) * m.l2 * std::cos(y[1]);
  const long double det = M1 * M2 - k * c * k * c;
  return {y[2], y[3], (M2 * f1 - k * c * f2) / det, (M1 * f2 - k * c * f1) / det};
}

/// Kinetic and potential energy (J) by the three centres of mass, not by M₁, M₂ and k.
inline long double guide_energy(const LooseGuide& m, const GuideState& y) {
  const auto point = [&](long double along1, long double along2) {  // speed² and height
    const long double vx = -along1 * y[2] * std::sin(y[0]) - along2 * y[3] * std::sin(y[1]);
    const long double vy = along1 * y[2] * std::cos(y[0]) + along2 * y[3] * std::cos(y[1]);
    return std::array{vx * vx + vy * vy, along1 * std::sin(y[0]) + along2 * std::sin(y[1])};
  };
  const auto [v1, h1] = point(m.l1 / 2, 0);
  const auto [v2, h2] = point(m.l1, m.l2 / 2);
  const auto [v3, h3] = point(m.l1, m.l2);
  return (m.m1 * v1 + m.m2 * v2 + m.m3 * v3 + m.J1 * y[2] * y[2] + m.J2 * y[3] * y[3]) / 2 +
         m.g * (m.m1 * h1 + m.m2 * h2 + m.m3 * h3);
}

/// The state at the time t (s) before any contact, by equal steps of order 8.
inline GuideState guide_flight(const LooseGuide& m, long double t, int steps = 200) {
  const CooperVerner<long double> method;
  const long double h = t / steps;
  GuideState y = guide_start;
  for (int i = 0; i < steps; ++i)
    y = method.step([&](long double, const GuideState& at) { return guide_rates(m, at); }, i * h, y, h);
  return y;
}

/// Height of the slider's centre relative to the clearance.
inline long double guide_height(const LooseGuide& m, const GuideState& y) {
  return (m.l1 * std::sin(y[0]) + m.l2 * std::sin(y[1])) / m.clearance;
}

}  // namespace freeplay::reference
