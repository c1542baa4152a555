// Closed forms of periodic motions with one impact, in extended precision, with the eigenvalues of their
// maps. Source: Guckenheimer and Holmes, Nonlinear Oscillations, Dynamical Systems, and Bifurcations of
// Vector Fields (1983), section 2.4 (ball on a vibrating table, here without the approximation of high
// bounces); Shaw and Holmes, J. Sound Vib. 90 (1983) 129 (impact oscillator). Units: SI.
#pragma once

#include <array>
#include <cmath>
#include <complex>

namespace freeplay::reference {

/// Eigenvalues of a matrix of two rows with this trace and determinant, the greatest modulus first.
inline std::array<std::complex<long double>, 2> multipliers(long double trace, long double determinant) {
  const long double half = trace / 2, square = half * half - determinant;
  if (square < 0) return {{{half, std::sqrt(-square)}, {half, -std::sqrt(-square)}}};
  const long double greater = half + std::copysign(std::sqrt(square), half);
  return {{greater, determinant / greater}};
}

/// A body of mass m on a table at the height A sin(ωt + φ₀), which carries a second one of mass M
/// on a spring of stiffness k with damping d; M = 0: none.
///
/// While the contact lasts, M z̈ + d ż + k z = M A ω² sin(ωt + φ₀) for the change z of the spring's
/// length. The force of the contact is (m + M) g + (m + M) ÿ + M z̈ with the table's height y. It
/// oscillates with the amplitude A ω² |m + M + M² ω²/(k − M ω² + i d ω)| about (m + M) g.
struct LoadedTable {
  long double frequency, gravity;  ///< ω in rad/s
  long double mass, upper = 0, stiffness = 0, damping = 0;

  static long double pi() { return std::acos(-1.0L); }
  long double period() const { return 2 * pi() / frequency; }
  long double shaken_mass() const {
    if (upper == 0) return mass;
    const long double w = frequency;
    const std::complex<long double> resistance(stiffness - upper * w * w, damping * w);
    return std::abs(mass + upper + upper * upper * w * w / resistance);
  }
  /// Amplitude at which the contact force comes to 0 once per period.
  long double liftoff() const { return (mass + upper) * gravity / (frequency * frequency * shaken_mass()); }
  /// One of the two conjugate multipliers, those of the oscillator: exp(s T) with M s² + d s + k = 0.
  std::complex<long double> multiplier() const {
    const long double decay = damping / (2 * upper);
    return std::exp(-decay * period()) *
           std::exp(std::complex<long double>(0, std::sqrt(stiffness / upper - decay * decay) * period()));
  }
};

/// A ball on a table at the height A sin(ωt + φ₀), one impact in n periods: T = 2πn/ω, at the phase φ.
///
/// The flight lasts T and ends at the height at which it began, so v⁺ = gT/2 = −v⁻. With the table's
/// velocity u = Aω cos φ, Newton's law v⁺ − u = −e (v⁻ − u) gives u = (gT/2)(1 − e)/(1 + e).
/// For small changes of time and velocity after one impact and those after the next,
///     dt′ = dt + T dv/c,  dv′ = −e (dv − g (dt′ − dt)) + (1 + e) a dt′,
/// with the approach speed c = gT/(1 + e) and the table's acceleration a = −Aω² sin φ. Hence the
/// determinant is e² and the trace 1 + e² + (1 + e)² a/g.
struct ShakenBall {
  long double amplitude, frequency, gravity, restitution;  ///< frequency ω in rad/s
  int number = 1;                                          ///< n
  bool rising = true;                                      ///< sin φ > 0
  long double start = 2;                                   ///< φ₀, rad

  static long double pi() { return std::acos(-1.0L); }
  long double period() const { return 2 * pi() * number / frequency; }
  long double table_speed() const { return gravity * period() / 2 * (1 - restitution) / (1 + restitution); }
  long double phase() const {
    const long double angle = std::acos(table_speed() / (amplitude * frequency));
    return rising ? angle : 2 * pi() - angle;
  }
  /// s, within the first period of the table
  long double impact_time() const {
    const long double turn = 2 * pi(), angle = phase() - start;
    return (angle - turn * std::floor(angle / turn)) / frequency;
  }
  long double approach() const { return gravity * period() / (1 + restitution); }
  long double determinant() const { return restitution * restitution; }
  long double trace() const {
    const long double acceleration = -amplitude * frequency * frequency * std::sin(phase());
    return 1 + restitution * restitution + (1 + restitution) * (1 + restitution) * acceleration / gravity;
  }
  /// Height above the table's mean and velocity at the time `after` (s) an impact.
  long double height(long double after) const {
    return amplitude * std::sin(phase()) + gravity * after * (period() - after) / 2;
  }
  long double velocity(long double after) const { return gravity * (period() / 2 - after); }
  /// Amplitude at which the motion appears (a multiplier 1): the table is fast enough only at φ = 0.
  long double fold() const { return table_speed() / frequency; }
  /// Amplitude at which a multiplier is −1: 1 + trace + determinant = 0.
  long double flip() const {
    const long double e = restitution,
                      sine = 2 * (1 + e * e) / ((1 + e) * (1 + e)) * gravity / (frequency * frequency);
    return std::hypot(sine, fold());
  }
};

/// An oscillator m ẍ + c ẋ + k x = F cos(Ωt + ψ) with a stop x ≤ d, one impact in n periods of the force,
/// at t = 0 and t = T = 2πn/Ω:
///
///     x = E_t (A cos ω_d t + B sin ω_d t) + C cos Ωt + S sin Ωt,   E_t = exp(−δt).
///
/// x(0) = x(T) = d and ẋ(0) = −e ẋ(T) are linear in A, B, C and S; C² + S² = X² with the amplitude X of
/// the steady oscillation then is a quadratic equation for A.
struct ImpactOscillator {
  long double mass, damping, stiffness, force, frequency, stop, restitution;  ///< frequency Ω in rad/s
  int number = 1;                                                             ///< n
  bool greater = true;                                                        ///< which root A

  struct Motion {
    long double decay, rate, A, B, C, S, v_plus, v_minus, psi;
  };
  long double period() const { return 2 * std::acos(-1.0L) * number / frequency; }
  Motion motion() const {
    Motion o{};
    o.decay = damping / (2 * mass);
    o.rate = std::sqrt(stiffness / mass - o.decay * o.decay);
    const long double T = period(), E = std::exp(-o.decay * T), cosine = std::cos(o.rate * T),
                      sine = std::sin(o.rate * T), inertial = stiffness - mass * frequency * frequency,
                      X = force / std::hypot(inertial, damping * frequency);
    const long double b = (1 - E * cosine) / (E * sine);  // B = b A
    const long double begin = -o.decay + o.rate * b;      // ẋ(0) = begin A + Ω S
    const long double end = E * (begin * cosine - (o.decay * b + o.rate) * sine);
    const long double s = -(end * restitution + begin) / (frequency * (1 + restitution));  // S = s A
    const long double root = std::sqrt(stop * stop - (1 + s * s) * (stop * stop - X * X));
    o.A = (stop + (greater ? root : -root)) / (1 + s * s);
    o.B = b * o.A;
    o.C = stop - o.A;
    o.S = s * o.A;
    o.v_plus = begin * o.A + frequency * o.S;
    o.v_minus = end * o.A + frequency * o.S;
    o.psi = std::atan2(-o.S, o.C) + std::atan2(damping * frequency, inertial);
    return o;
  }
  long double position(const Motion& o, long double t) const {
    return std::exp(-o.decay * t) * (o.A * std::cos(o.rate * t) + o.B * std::sin(o.rate * t)) +
           o.C * std::cos(frequency * t) + o.S * std::sin(frequency * t);
  }
  long double velocity(const Motion& o, long double t) const {
    const long double c = std::cos(o.rate * t), s = std::sin(o.rate * t);
    return std::exp(-o.decay * t) *
               ((-o.decay * o.A + o.rate * o.B) * c + (-o.decay * o.B - o.rate * o.A) * s) +
           frequency * (-o.C * std::sin(frequency * t) + o.S * std::cos(frequency * t));
  }
  /// Force at which both motions coincide (a multiplier 1): the quadratic equation for A has one root.
  long double fold() const {
    const auto m = motion();
    const long double s = m.S / m.A;
    return stop * std::abs(s) / std::sqrt(1 + s * s) * resistance();
  }
  /// Force at which the steady oscillation reaches the stop without impact, X = d.
  long double grazing() const { return stop * resistance(); }
  /// F/X of the steady oscillation.
  long double resistance() const {
    return std::hypot(stiffness - mass * frequency * frequency, damping * frequency);
  }
  long double determinant() const { return restitution * restitution * std::exp(-damping / mass * period()); }
  /// Of the free oscillation over T, followed by the impact, whose time varies with the state:
  ///     dx⁺ = −e dx⁻,   dv⁺ = −e dv⁻ + (a⁺ + e a⁻)/v⁻ dx⁻.
  long double trace() const {
    const auto o = motion();
    const long double T = period(), E = std::exp(-o.decay * T);
    const auto acceleration = [&](long double v) {
      return (force * std::cos(o.psi) - damping * v - stiffness * stop) / mass;
    };
    return -2 * restitution * E * std::cos(o.rate * T) +
           E * std::sin(o.rate * T) / o.rate *
               (acceleration(o.v_plus) + restitution * acceleration(o.v_minus)) / o.v_minus;
  }
};

// A body of mass m on a table at the height A sin(ωt + φ₀), held by gravity on a linear contact K, D.
// With the displacement z of the body relative to the table, positive away from it,
//
//     m z̈ + D ż + K z = −m g + m A ω² sin(ωt + φ₀),
//     F = −K z − D ż = m g − Im(m A ω² R e^{i(ωt + φ₀)}),
//     R = (K + iDω)/(K − mω² + iDω),
//
// as long as F ≥ 0. Hence the contact is lost at the amplitude g/(ω²|R|): without damping at
// A ω² = g |1 − (ω/ω₀)²| with ω₀² = K/m, instead of A ω² = g for a rigid contact.

struct CompliantTable {
  long double frequency, gravity, mass, stiffness, damping;  ///< ω in rad/s; K in N/m, D in N s/m
  long double start = 2;                                     ///< φ₀, rad

  using Complex = std::complex<long double>;
  /// The same body on its spring, without a lower one.
  LoadedTable loaded() const { return {frequency, gravity, 0, mass, stiffness, damping}; }
  Complex resistance() const { return {stiffness - mass * frequency * frequency, damping * frequency}; }
  long double liftoff() const { return loaded().liftoff(); }
  long double least_force(long double amplitude) const {
    return mass * gravity - amplitude * frequency * frequency * loaded().shaken_mass();
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
  Complex multiplier() const { return loaded().multiplier(); }
};

}  // namespace freeplay::reference
