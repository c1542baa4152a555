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
// Butterworth low-pass of order n with unit gain at zero frequency, −3 dB at f, on the impulse P
// δ(t):
//
//     H(s) = ω_cⁿ / Π (s − s_k),     s_k = ω_c e^{iπ(2k + n − 1)/(2n)},  k = 1 … n,     ω_c = 2π f
//     ∫₀^∞ y dt = Y(0) = P H(0) = P                the Laplace transform at s = 0, for any n and f
//     y(t) = P Σ r_k e^{s_k t},                    r_k = ω_cⁿ / Π_{j≠k} (s_k − s_j)
//     ∫₀ᵗ y = P + P Σ (r_k/s_k) e^{s_k t}
//
// Order 2, with a = ω_c t/√2:
//
//     y(t) = √2 ω_c P e^{−a} sin a,     ∫₀ᵗ y = P [1 − e^{−a} (cos a + sin a)]
//     greatest ω_c P e^{−π/4} at a = π/4, first zero at a = π
//
// Sign convention: heights and speeds are magnitudes, P ≥ 0 pushes the ball off the wall; t from
// the impulse, y = 0 before it. Units: m, kg, s, N s, Hz; y in N if P is in N s.
// Source: elementary; Oppenheim and Willsky, Signals and Systems, for the Butterworth filter.
#pragma once

#include <cmath>
#include <complex>
#include <stdexcept>
#include <vector>

namespace freeplay::reference {

/// Impulse (N s) of the wall on a ball of `mass` (kg) dropped from `height` (m) under `gravity`
/// (m/s²).
template <class Real>
Real drop_impulse(Real mass, Real height, Real restitution, Real gravity) {
  using std::sqrt;
  return mass * (1 + restitution) * sqrt(2 * gravity * height);
}

/// Order 2: response (N) at t (s) after the impulse (N s); `bandwidth` f in Hz.
template <class Real>
Real low_pass2_response(Real bandwidth, Real impulse, Real t) {
  using std::atan, std::exp, std::sin, std::sqrt;
  if (t < 0) return 0;
  const Real w = 8 * atan(Real(1)) * bandwidth, a = w * t / sqrt(Real(2));
  return sqrt(Real(2)) * w * impulse * exp(-a) * sin(a);
}

/// Order 2: integral (N s) of that response from 0 to t.
template <class Real>
Real low_pass2_integral(Real bandwidth, Real impulse, Real t) {
  using std::atan, std::cos, std::exp, std::sin, std::sqrt;
  if (t < 0) return 0;
  const Real a = 8 * atan(Real(1)) * bandwidth * t / sqrt(Real(2));
  return impulse * (1 - exp(-a) * (cos(a) + sin(a)));
}

/// Poles s_k (1/s) and residues r_k (1/s) of any order.
template <class Real>
struct LowPassModes {
  std::vector<std::complex<Real>> pole, residue;
};

template <class Real>
LowPassModes<Real> low_pass_modes(int order, Real bandwidth) {
  using std::atan;
  if (order < 1) throw std::invalid_argument("low_pass_modes: orders count from 1");
  const Real pi = 4 * atan(Real(1)), w = 2 * pi * bandwidth;
  LowPassModes<Real> modes;
  std::vector<std::complex<Real>> unit;  // poles over ω_c
  for (int k = 1; k <= order; ++k) {
    unit.push_back(std::polar(Real(1), pi * Real(2 * k + order - 1) / Real(2 * order)));
  }
  for (std::size_t k = 0; k < unit.size(); ++k) {
    std::complex<Real> product = 1;
    for (std::size_t j = 0; j < unit.size(); ++j) {
      if (j != k) product *= unit[k] - unit[j];
    }
    modes.pole.push_back(w * unit[k]);
    modes.residue.push_back(w / product);
  }
  return modes;
}

/// Any order: response (N) at t ≥ 0 (s) after the impulse (N s).
template <class Real>
Real low_pass_response(int order, Real bandwidth, Real impulse, Real t) {
  if (t < 0) return 0;
  const LowPassModes<Real> modes = low_pass_modes(order, bandwidth);
  std::complex<Real> sum = 0;
  for (std::size_t k = 0; k < modes.pole.size(); ++k) sum += modes.residue[k] * std::exp(modes.pole[k] * t);
  return impulse * sum.real();
}

/// Any order: integral (N s) of that response from 0 to t.
template <class Real>
Real low_pass_integral(int order, Real bandwidth, Real impulse, Real t) {
  if (t < 0) return 0;
  const LowPassModes<Real> modes = low_pass_modes(order, bandwidth);
  std::complex<Real> sum = 1;
  for (std::size_t k = 0; k < modes.pole.size(); ++k) {
    sum += modes.residue[k] / modes.pole[k] * std::exp(modes.pole[k] * t);
  }
  return impulse * sum.real();
}

}  // namespace freeplay::reference
