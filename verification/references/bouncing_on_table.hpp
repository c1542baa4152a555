// A ball that bounces on a table moving as s(t) = A sin ωt, restitution e < 1 at every impact, the
// table undisturbed. With Γ = A ω²/g, T = 2π/ω, and v the ball's velocity right after an impact at
// t:
//
//     s(t) + v τ − g τ²/2 = s(t'),  t' = t + τ,      v' = (1 + e) ṡ(t') − e (v − g τ)
//
// One impact in every n periods needs τ = nT and the same height, so v* = g nT/2 and
// v* = (1 + e)V + e v* with V = ṡ:
//
//     V = v* (1 − e)/(1 + e)   ⇔   cos φ = n π (1 − e)/((1 + e) Γ),       φ = ω t,
//     0 < φ < π/2 (else it is unstable);
//     it exists from Γ = n π (1 − e)/(1 + e) on;
//     the approach is w = V + v* = 2 v*/(1 + e) = g nT/(1 + e).
//
// Linearised about it, with τ/(V + v*) = (1 + e)/g and s̈ = −Aω² sin φ,
//
//     δt' = δt + (1 + e)/g δv,      δv' = (1 + e) s̈ δt + ((1 + e)² s̈/g + e²) δv
//     determinant e²,      trace 1 + e² − (1 + e)² Γ sin φ
//
// so that an eigenvalue is −1, and the period doubles, at (1 + e)² Γ sin φ = 2(1 + e²):
//
//     Γ² = (n π (1 − e)/(1 + e))² + (2(1 + e²)/(1 + e)²)²
//
// No step assumes that the table's travel is small: the result is exact. A ball that rests stays on
// the table while Γ < 1, where the
// table never falls faster than g.
// Sign convention: heights and velocities upwards; w > 0 approaches. Units: m, s.
// Sources: derived here; the same in Holmes, J. Sound Vib. 84 (1982) 173 (with the travel
// neglected); Tufillaro, Abbott and
// Reilly, An Experimental Approach to Nonlinear Dynamics and Chaos (1992), ch. 1.
#pragma once

#include <cmath>
#include <numbers>

namespace freeplay::reference {

struct BallOnTable {
  double restitution, gravity, omega;  ///< e in [0, 1); m/s²; rad/s
  int turns = 1;                       ///< n

  double period() const { return 2 * std::numbers::pi / omega; }
  double least() const { return turns * std::numbers::pi * (1 - restitution) / (1 + restitution); }
  /// Γ above which the orbit exists.
  double birth() const { return least(); }
  /// Γ at which its period doubles.
  double doubling() const {
    const double e = restitution;
    return std::hypot(least(), 2 * (1 + e * e) / ((1 + e) * (1 + e)));
  }
  /// rad, phase of the stable orbit at Γ.
  double phase(double strength) const { return std::acos(least() / strength); }
  /// m/s, at every impact.
  double approach() const { return gravity * turns * period() / (1 + restitution); }
};

}  // namespace freeplay::reference
