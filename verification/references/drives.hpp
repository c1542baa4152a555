// Closed forms of the effect of drives on a rotor of inertia J or a slider of mass m. Nothing is
// integrated numerically here.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>

namespace freeplay::reference {

/// DC motor on a free rotor from rest, L di/dt = U − R i − k ω, J dω/dt = k i: with p the roots of
/// L J p² + R J p + k² = 0
///     ω = (U/k) (1 + (p₂ e^{p₁t} − p₁ e^{p₂t})/(p₁ − p₂)),
///     without L: ω = (U/k)(1 − e^{−t/τ}), τ = R J/k².
struct DcSpinUp {
  double U, R, k, L, J;
  double speed(double t) const {
    if (L == 0) return U / k * -std::expm1(-t * k * k / (R * J));
    using C = std::complex<double>;
    const C root = std::sqrt(C(R * R * J * J - 4 * L * J * k * k));
    const C p1 = (-R * J + root) / (2 * L * J), p2 = (-R * J - root) / (2 * L * J);
    return U / k * (1.0 + (p2 * std::exp(p1 * t) - p1 * std::exp(p2 * t)) / (p1 - p2)).real();
  }
};

/// Kloss's formula against a constant load M < M_k, on its stable branch: s/s_k + s_k/s = 2 M_k/M,
///     s = s_k (M_k/M − √((M_k/M)² − 1)).
inline double kloss_slip(double breakdown_torque, double breakdown_slip, double load) {
  const double ratio = breakdown_torque / load;
  return breakdown_slip * (ratio - std::sqrt(ratio * ratio - 1));
}

/// PI governor on a free rotor from rest: e = Ω − ω, J ë + k_p ė + k_i e = 0, e(0) = Ω, ė(0) = −k_p
/// Ω/J, under-damped:
///     e = Ω e^{−δt} (cos wt − (δ/w) sin wt),     δ = k_p/(2J),  w² = k_i/J − δ².
inline double governed_speed(double target, double kp, double ki, double J, double t) {
  const double d = kp / (2 * J), w = std::sqrt(ki / J - d * d);
  return target * (1 - std::exp(-d * t) * (std::cos(w * t) - d / w * std::sin(w * t)));
}

/// A rise by 1 within 0 ≤ s ≤ 1: its integral, itself and its derivatives. 3-4-5: p = 10 s³ − 15
/// s⁴ + 6 s⁵; cycloidal: p = s − sin(2πs)/(2π).
struct Rise {
  double integral, value, slope, bend;
};
inline Rise polynomial_rise(double s) {
  return {s * s * s * s * (2.5 - 3 * s + s * s), s * s * s * (10 - 15 * s + 6 * s * s),
          30 * s * s * (1 - s) * (1 - s), 60 * s * (1 - s) * (1 - 2 * s)};
}
inline Rise cycloidal_rise(double s) {
  const double w = 2 * std::numbers::pi;
  return {s * s / 2 + (std::cos(w * s) - 1) / (w * w), s - std::sin(w * s) / w, 1 - std::cos(w * s),
          w * std::sin(w * s)};
}

}  // namespace freeplay::reference
