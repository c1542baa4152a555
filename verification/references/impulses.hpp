// Impulses that recorded forces must add up to.
//
// A ball of the mass m dropped from rest at the height h on a wall, restitution e: its speed is √(2
// g h) before and e √(2 g h) after the impact, so the wall's impulse is
//
//     P = m (1 + e) √(2 g h)
//
// for an impact without duration. The impulse of a contact of the duration T includes that of the
// weight, P + m g T, with h measured to first contact and e the ratio of the speeds at its ends.
//
// Butterworth low-pass of order 2 with unit gain at zero frequency, −3 dB at f, on the impulse P
// δ(t), with ω_c = 2π f and a = ω_c t/√2:
//
//     ÿ + √2 ω_c ẏ + ω_c² y = ω_c² P δ(t),     y(t) = √2 ω_c P e^{−a} sin a
//     greatest ω_c P e^{−π/4} at a = π/4, first zero at a = π
//
// Sign convention: heights and speeds are magnitudes, P ≥ 0 pushes the ball off the wall; t from
// the impulse, y = 0 before it. Units: m, kg, s, N s, Hz; y in N if P is in N s.
// Source: elementary; Oppenheim and Willsky, Signals and Systems, for the Butterworth filter.
#pragma once

#include <cmath>

namespace freeplay::reference {

/// Impulse (N s) of the wall on a ball of `mass` (kg) dropped from `height` (m) under `gravity`
/// (m/s²).
template <class Real>
Real drop_impulse(Real mass, Real height, Real restitution, Real gravity) {
  using std::sqrt;
  return mass * (1 + restitution) * sqrt(2 * gravity * height);
}

/// Response (N) of the filter at t (s) after the impulse (N s); `bandwidth` f in Hz.
template <class Real>
Real low_pass2_response(Real bandwidth, Real impulse, Real t) {
  using std::atan, std::exp, std::sin, std::sqrt;
  if (t < 0) return 0;
  const Real w = 8 * atan(Real(1)) * bandwidth, a = w * t / sqrt(Real(2));
  return sqrt(Real(2)) * w * impulse * exp(-a) * sin(a);
}

}  // namespace freeplay::reference
