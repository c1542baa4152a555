// Friction in ideal joints, in closed form. A pin of radius r carries the force F and resists with
// a couple of at most μ r |F| (the friction circle: F passes the pin's centre at μ r); a guide
// resists with at most μ S.
#pragma once

#include <cmath>

namespace freeplay::reference {

/// A wheel that turns on a pin at its centre: F = m g, so ω̇ = −μ r m g/J until it stops.
inline double wheel_deceleration(double mu, double r, double m, double g, double J) {
  return mu * r * m * g / J;
}

/// The same with Stribeck's μ(u) = μ + (μ_s − μ) exp(−(u/v)²), u = r ω: the time from ω₀ down to
/// ω₁, t = ∫ J dω/(r m g μ(rω)), by Simpson's rule on 20 000 intervals.
inline double stribeck_time(double mu, double mu_s, double v, double r, double m, double g, double J,
                            double w0, double w1) {
  const auto slowness = [&](double w) {
    const double x = r * w / v;
    return J / (r * m * g * (mu + (mu_s - mu) * std::exp(-x * x)));
  };
  const int n = 20'000;
  const double h = (w0 - w1) / n;
  double sum = slowness(w1) + slowness(w0);
  for (int i = 1; i < n; ++i) sum += (i % 2 ? 4 : 2) * slowness(w1 + i * h);
  return sum * h / 3;
}

/// A rotor whose centre of mass lies ε off its pin, without weight: |F| = m ε √(ω⁴ + ω̇²) contains
/// ω̇ itself. With
/// k = μ r m ε/J_p, J_p about the pin, ω̇² = k²(ω⁴ + ω̇²): ω̇ = −ω² k/√(1 − k²) for k < 1, and no
/// motion for k ≥ 1.
struct EccentricRotor {
  double mu, r, m, epsilon, J_p;
  double k() const { return mu * r * m * epsilon / J_p; }
  /// ω(t) = ω₀/(1 + c ω₀ t)
  double speed(double w0, double t) const {
    const double c = k() / std::sqrt(1 - k() * k());
    return w0 / (1 + c * w0 * t);
  }
};

/// A rod on a pin, its centre of mass at l, that hits a wall at a with the speed v of that point,
/// Newton's law with e.
/// With w = v/a the impulses P of the wall and Λ of the pin obey J_p (1 + e) w = a P − μ r |Λ| and
/// Λ = m l (1 + e) w − P ≥ 0 (for a beyond the centre of percussion); friction resists the rotation
/// after the impact.
inline double rod_impulse(double mu, double r, double m, double l, double a, double J_p, double e, double v) {
  return (1 + e) * v / a * (J_p + mu * r * m * l) / (a + mu * r);
}

/// A slider of length L on a guide, pulled along it by a force at arm b off the axis: the couple F
/// b presses its ends with
/// 2 F b/L, whose friction is the share k = 2 μ b/L of F. It slides with (1 − k) F/m, and is
/// self-locking for any F where k ≥ 1.
inline double cantilever_share(double mu, double b, double L) { return 2 * mu * b / L; }

}  // namespace freeplay::reference
