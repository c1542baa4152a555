// Derivatives of closed-form motions with impacts and friction, in extended precision. Each function
// differentiates its formula by hand.
//
// Sign convention: heights upwards, gravity g > 0 downwards. Units: SI.
// Source: elementary mechanics; the pendulum by complete elliptic integrals of modulus k,
//     dK/dk = E/(k (1 − k²)) − K/k      (Byrd and Friedman, Handbook of Elliptic Integrals, 710.00).
#pragma once

#include <cmath>

namespace freeplay::reference {

using Extended = long double;

/// A ball released at the height H above a floor: n-th impact, with derivatives with respect to the
/// restitution e, the height and gravity.
struct BallDerivatives {
  Extended height, gravity, restitution;

  Extended first() const { return std::sqrt(2 * height / gravity); }
  /// t_n = t₁ (1 + 2 Σ eⁱ), i = 1 … n − 1
  Extended time(int n) const {
    Extended sum = 0;
    for (int i = 1; i < n; ++i) sum += std::pow(restitution, Extended(i));
    return first() * (1 + 2 * sum);
  }
  Extended time_by_restitution(int n) const {
    Extended sum = 0;
    for (int i = 1; i < n; ++i) sum += i * std::pow(restitution, Extended(i - 1));
    return 2 * first() * sum;
  }
  Extended time_by_height(int n) const { return time(n) / (2 * height); }
  Extended time_by_gravity(int n) const { return -time(n) / (2 * gravity); }
  /// v_n = e^(n−1) √(2 g H)
  Extended speed(int n) const {
    return std::pow(restitution, Extended(n - 1)) * std::sqrt(2 * gravity * height);
  }
  Extended speed_by_restitution(int n) const { return (n - 1) * speed(n) / restitution; }
  /// t_∞ = t₁ (1 + e)/(1 − e)
  Extended rest() const { return first() * (1 + restitution) / (1 - restitution); }
  Extended rest_by_restitution() const { return 2 * first() / ((1 - restitution) * (1 - restitution)); }
  /// Height at T after one impact, h = e v₁ (T − t₁) − g (T − t₁)²/2 with v₁ = √(2 g H), by H.
  Extended end_by_height(Extended end) const {
    return (1 + restitution) * gravity * (end - first()) / speed(1) - restitution;
  }
  /// Energy lost in n impacts over the mass: g H (1 − e^(2n)).
  Extended loss_by_restitution(int n) const {
    return -2 * n * std::pow(restitution, Extended(2 * n - 1)) * gravity * height;
  }
  /// Mean force of the floor over [0, T], n impacts before T: m g + m v(T)/T with
  /// v(T) = eⁿ √(2 g H) − g (T − t_n).
  Extended mean_force_by_restitution(int n, Extended mass, Extended end) const {
    return mass / end *
           (n * std::pow(restitution, Extended(n - 1)) * std::sqrt(2 * gravity * height) +
            gravity * time_by_restitution(n));
  }
};

/// Complete elliptic integrals of modulus k by the arithmetic–geometric mean.
struct CompleteElliptic {
  Extended K, E;
  explicit CompleteElliptic(Extended k) {
    Extended a = 1, b = std::sqrt(1 - k * k), c = k, sum = c * c / 2, power = 0.5L;
    for (int i = 0; i < 40 && std::abs(c) > 1e-19L; ++i) {
      const Extended mean = (a + b) / 2;
      c = (a - b) / 2;
      b = std::sqrt(a * b);
      a = mean;
      power *= 2;
      sum += power * c * c;
    }
    K = std::acos(Extended(-1)) / (2 * a);
    E = K * (1 - sum);
  }
  /// dK/dk
  Extended slope(Extended k) const { return E / (k * (1 - k * k)) - K / k; }
};

/// A pendulum of angular frequency ω = √(m g a/J) released at rest at the angle θ₀ from the vertical,
/// with a wall at the vertical:
///     t₁ = K(k)/ω,  t₂ = t₁ + 2 K(e k)/ω,  k = sin(θ₀/2).
struct PendulumWall {
  Extended frequency, amplitude, restitution;

  Extended modulus() const { return std::sin(amplitude / 2); }
  Extended first() const { return CompleteElliptic(modulus()).K / frequency; }
  Extended second() const { return first() + 2 * CompleteElliptic(restitution * modulus()).K / frequency; }
  Extended second_by_restitution() const {
    const Extended k = restitution * modulus();
    return 2 * modulus() * CompleteElliptic(k).slope(k) / frequency;
  }
  Extended first_by_amplitude() const {
    const Extended k = modulus();
    return CompleteElliptic(k).slope(k) * std::cos(amplitude / 2) / 2 / frequency;
  }
  Extended second_by_amplitude() const {
    const Extended k = restitution * modulus();
    return first_by_amplitude() +
           CompleteElliptic(k).slope(k) * restitution * std::cos(amplitude / 2) / frequency;
  }
  Extended second_by_gravity(Extended g) const { return -second() / (2 * g); }
  /// Of the angle of the wall, at the vertical: θ̇ = 2 ω k there.
  Extended first_by_wall() const { return -1 / (2 * frequency * modulus()); }
};

/// A disc without spin released at rest at the height H above a plane, gravity with components
/// (g_t, −g_n). It slides throughout the first impact: P_T = −μ (1 + e) m g_n t₁. Position at T, between the
/// first and second impact:
///     x = g_t T²/2 − μ (1 + e) g_n t₁ (T − t₁),  t₁ = √(2H/g_n).
struct ObliqueDrop {
  Extended height, along, normal, restitution, friction, end;

  Extended first() const { return std::sqrt(2 * height / normal); }
  Extended by_friction() const { return -(1 + restitution) * normal * first() * (end - first()); }
  Extended by_restitution() const { return -friction * normal * first() * (end - first()); }
  Extended by_height() const {
    return -friction * (1 + restitution) * normal * (end - 2 * first()) * first() / (2 * height);
  }
  Extended by_along() const { return end * end / 2; }
  /// g_n t₁ (T − t₁) = √(2 H g_n) T − 2 H
  Extended by_normal() const {
    return -friction * (1 + restitution) * std::sqrt(2 * height / normal) * end / 2;
  }
};

/// A block that slides to rest: x = v²/(2a) with the deceleration a = d + μ n, d along the plane and n
/// the normal acceleration.
struct SlidingBlock {
  Extended speed, along, normal, friction;

  Extended deceleration() const { return along + friction * normal; }
  Extended by_speed() const { return speed / deceleration(); }
  Extended by_friction() const { return -speed * speed * normal / (2 * deceleration() * deceleration()); }
  Extended by_along() const { return -speed * speed / (2 * deceleration() * deceleration()); }
};

/// Two discs in line, m₁ at x₁ with speed v₁, m₂ at rest at x₂; d: sum of the radii. With
/// t_c = (x₂ − x₁ − d)/v₁,
///     v₁⁺ = v₁ (m₁ − e m₂)/M,  v₂⁺ = v₁ (1 + e) m₁/M,  M = m₁ + m₂,  x₂(T) = x₂ + v₂⁺ (T − t_c).
struct HeadOn {
  Extended mass1, mass2, x1, x2, v1, radii, restitution, end;

  Extended total() const { return mass1 + mass2; }
  Extended contact() const { return (x2 - x1 - radii) / v1; }
  Extended after2_by_v1() const { return (1 + restitution) * mass1 / total(); }
  Extended after2_by_restitution() const { return v1 * mass1 / total(); }
  Extended after2_by_mass1() const { return v1 * (1 + restitution) * mass2 / (total() * total()); }
  Extended end2_by_x1() const { return (1 + restitution) * mass1 / total(); }
  Extended end2_by_x2() const { return 1 - (1 + restitution) * mass1 / total(); }
  Extended impulse_by_mass1() const { return v1 * (1 + restitution) * mass2 * mass2 / (total() * total()); }
};

/// A ball dropped from rest at the height H above a linear spring K without damping. In contact,
/// m δ̈ = m g − K δ with δ̇ = v₀ = √(2 g H) at its beginning:
///     δ = (g/ω²) (1 − cos ωτ) + (v₀/ω) sin ωτ,  ω² = K/m,
/// which vanishes at ωτ = θ with tan(θ/2) = −v₀ ω/g, that is θ = 2π − 2 atan(v₀ ω/g). The ball leaves with
/// v₀; the second contact begins at t₂ = √(2H/g) + θ/ω + 2 v₀/g. Impulse of the contact: 2 m v₀ + m g θ/ω.
struct SpringBounce {
  Extended height, gravity, mass, stiffness;

  Extended speed() const { return std::sqrt(2 * gravity * height); }
  Extended frequency() const { return std::sqrt(stiffness / mass); }
  Extended ratio() const { return speed() * frequency() / gravity; }
  Extended angle() const { return 2 * std::acos(Extended(-1)) - 2 * std::atan(ratio()); }
  Extended duration() const { return angle() / frequency(); }
  Extended second() const { return std::sqrt(2 * height / gravity) + duration() + 2 * speed() / gravity; }
  /// d(θ/ω)/dω
  Extended duration_by_frequency() const {
    return -2 * speed() / gravity / (1 + ratio() * ratio()) / frequency() -
           angle() / (frequency() * frequency());
  }
  /// ω changes by ω/(2K) per K and by −ω/(2m) per m.
  Extended second_by_stiffness() const { return duration_by_frequency() * frequency() / (2 * stiffness); }
  Extended second_by_mass() const { return -duration_by_frequency() * frequency() / (2 * mass); }
  Extended duration_by_speed() const { return -2 / gravity / (1 + ratio() * ratio()); }
  Extended second_by_height() const {
    const Extended by_height = speed() / (2 * height);
    return std::sqrt(2 * height / gravity) / (2 * height) + (duration_by_speed() + 2 / gravity) * by_height;
  }
  Extended impulse_by_mass() const {
    return 2 * speed() + gravity * duration() + mass * gravity * second_by_mass();
  }
  Extended impulse_by_stiffness() const { return mass * gravity * second_by_stiffness(); }
};

/// A ball without gravity meets a wall at the distance L with the speed v, and leaves with ê v towards
/// another at the distance B from the first. For F = K δⁿ (1 + χ δ̇/v₀), lengths and times of the contact
/// scale: its duration is T = C(χ, n) (m/K)^(1/(n+1)) v^((1−n)/(n+1)), and ê does not depend on m, K and v.
///     t₂ = L/v + T + B/(ê v)
struct ScaledContact {
  Extended first, between, speed, delivered, exponent, duration;  ///< duration: T

  Extended second_by_mass(Extended mass) const { return duration / ((exponent + 1) * mass); }
  Extended second_by_stiffness(Extended stiffness) const { return -duration / ((exponent + 1) * stiffness); }
  Extended second_by_speed() const {
    return -first / (speed * speed) + (1 - exponent) / (exponent + 1) * duration / speed -
           between / (delivered * speed * speed);
  }
};

}  // namespace freeplay::reference
