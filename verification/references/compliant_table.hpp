// A body of mass m on a table at the height A sin(ωt + φ₀), held by gravity on a linear contact K, D.
// With the displacement z of the body relative to the table, positive away from it,
//
//     m z̈ + D ż + K z = −m g + m A ω² sin(ωt + φ₀),
//     F = −K z − D ż = m g − Im(m A ω² R e^{i(ωt + φ₀)}),
//     R = (K + iDω)/(K − mω² + iDω),
//
// as long as F ≥ 0. Hence the contact is lost at the amplitude g/(ω²|R|): without damping at
// A ω² = g |1 − (ω/ω₀)²| with ω₀² = K/m, instead of A ω² = g for a rigid contact.
#pragma once

#include <cmath>
#include <complex>

namespace freeplay::reference {

struct CompliantTable {
  long double frequency, gravity, mass, stiffness, damping;  ///< ω in rad/s; K in N/m, D in N s/m
  long double start = 2;                                     ///< φ₀, rad

  using Complex = std::complex<long double>;
  static long double pi() { return std::acos(-1.0L); }
  long double period() const { return 2 * pi() / frequency; }
  Complex resistance() const { return {stiffness - mass * frequency * frequency, damping * frequency}; }
  Complex ratio() const { return Complex(stiffness, damping * frequency) / resistance(); }
  long double liftoff() const { return gravity / (frequency * frequency * std::abs(ratio())); }
  long double least_force(long double amplitude) const {
    return mass * (gravity - amplitude * frequency * frequency * std::abs(ratio()));
  }
  /// The oscillation m A ω² e^{iφ₀}/resistance at t = 0; z and ż are imaginary parts.
  Complex oscillation(long double amplitude) const {
    return mass * amplitude * frequency * frequency * std::exp(Complex(0, start)) / resistance();
  }
  long double distance(long double amplitude) const {
    return oscillation(amplitude).imag() - mass * gravity / stiffness;
  }
  long double speed(long double amplitude) const {
    return (Complex(0, frequency) * oscillation(amplitude)).imag();
  }
  /// One of the two conjugate multipliers: exp(s T) with m s² + D s + K = 0.
  Complex multiplier() const {
    const long double decay = damping / (2 * mass);
    return std::exp(Complex(-decay, std::sqrt(stiffness / mass - decay * decay)) * period());
  }
};

}  // namespace freeplay::reference
