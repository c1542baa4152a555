// Undamped impact of a mass m at the speed v on the spring F = K δⁿ (n = 3/2: Hertz). The energy,
// ½ m v² = K δⁿ⁺¹/(n + 1), gives
//
//     δ_max = [(n + 1) m v² / (2K)]^{1/(n+1)}               n = 3/2: (5 m v²/(4K))^{2/5}
//     T = 2 (δ_max/v) ∫₀¹ dz/√(1 − zⁿ⁺¹) = C_n δ_max/v
//     C_n = 2/(n+1) B(1/(n+1), ½) = 2 √π Γ(1 + 1/(n+1)) / Γ(½ + 1/(n+1))
//
// C_1 = π (a linear spring) and C_{3/2} = 2 √π Γ(1.4)/Γ(0.9) = 2.943275…
// Sign convention: δ > 0 is penetration, v > 0 the approach speed. Units: m, kg, s, K in N/mⁿ. For
// two bodies m is the effective mass, the inverse of the contact's Delassus element.
// Source: Goldsmith, Impact (1960); Johnson, Contact Mechanics (1985), §11.4, prints 2.94; 2.9432
// is the truncated value.
#pragma once

#include <cmath>
#include <stdexcept>

namespace freeplay::reference {

struct ElasticImpact {
  double depth;     ///< m, δ_max
  double duration;  ///< s, from first contact to separation
  double force;     ///< N, greatest, K δ_maxⁿ
  double impulse;   ///< N s, 2 m v
};

/// C_n of the duration C_n δ_max/v.
inline double impact_duration_constant(double n = 1.5) {
  const double pi = 3.141592653589793238462643383279503;
  const double p = 1 / (n + 1);
  return 2 * std::sqrt(pi) * std::tgamma(1 + p) / std::tgamma(0.5 + p);
}

/// Impact of the mass (kg) at the speed (m/s) on a spring of the stiffness K (N/mⁿ) and exponent n.
inline ElasticImpact elastic_impact(double stiffness, double mass, double speed, double n = 1.5) {
  if (!(stiffness > 0 && mass > 0 && speed > 0 && n > 0)) {
    throw std::invalid_argument("elastic_impact: need K, m, v, n > 0");
  }
  ElasticImpact impact{};
  impact.depth = std::pow((n + 1) * mass * speed * speed / (2 * stiffness), 1 / (n + 1));
  impact.duration = impact_duration_constant(n) * impact.depth / speed;
  impact.force = stiffness * std::pow(impact.depth, n);
  impact.impulse = 2 * mass * speed;
  return impact;
}

}  // namespace freeplay::reference
