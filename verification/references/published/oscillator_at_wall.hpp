// A point mass m on an isotropic spring of rate K in the field g against a wall x = 0, which the
// spring presses it to:
//
//     m ẍ = −K x − m g,    x ≥ 0,    ẋ⁺ = −e ẋ⁻;         m ÿ = −K y   (free along the wall)
//
// With ω² = K/m and c = g/ω² the flight that leaves the wall at v is x = −c + c cos ωt + (v/ω) sin
// ωt. It lasts (2/ω) atan(v/(ω c)) and returns with v. Released from rest at x₀, the mass arrives
// after acos(c/(c + x₀))/ω with √((2 c + x₀) x₀) ω. The rebounds e^n v₁ accumulate at a finite
// time, since a slow flight lasts 2 v/g.
// Source: derived here. Parameters: Siconos, siconos-tutorials,
// examples/mechanics/BouncingBallEventDriven/LinearOscillatorED.cpp. Units: kg, m, s.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace freeplay::reference {

struct OscillatorAtWall {
  long double mass = 1e-3L, stiffness = 100, gravity = 9.81L, restitution = 0.9L, x0 = 1, y0 = 1e-3L;

  struct Impact {
    long double t, approach, impulse;  ///< s, m/s, N s
  };
  long double omega() const { return std::sqrt(stiffness / mass); }
  long double sag() const { return gravity * mass / stiffness; }
  long double flight(long double v) const { return 2 / omega() * std::atan(v / (omega() * sag())); }

  /// The n-th impact, n ≥ 1.
  Impact impact(int n) const {
    long double t = std::acos(sag() / (sag() + x0)) / omega();
    long double v = omega() * std::sqrt((2 * sag() + x0) * x0);
    for (int k = 1; k < n; ++k) t += flight(v *= restitution);
    return {t, v, (1 + restitution) * mass * v};
  }
  /// Time at which the impacts accumulate: the flights after the n-th last 2 e v/(g (1 − e))
  /// together, up to a fraction (v/(ω c))²/3.
  long double accumulation() const {
    constexpr int many = 400;
    const auto last = impact(many);
    return last.t + 2 * restitution * last.approach / (gravity * (1 - restitution));
  }
  long double along_wall(long double t) const { return y0 * std::cos(omega() * t); }
};

/// Rows of LinearOscillatorED.ref (siconos-tutorials, commit 286a951): the times of two of its
/// impacts, the 92nd and the one after which it leaves the ball at rest.
inline constexpr double published_impact_92 = 0.8321809327194379;  // s
inline constexpr double published_rest = 0.8702795134611794;       // s

}  // namespace freeplay::reference
