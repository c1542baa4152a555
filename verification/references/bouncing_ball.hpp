// A ball released at rest at the height H above a floor, restitution e at every impact:
//
//     t₁ = √(2H/g),  v₁ = g t₁                                      first impact
//     v_k = e^{k−1} v₁                                              approach speed of the k-th
//     t_k = t₁ [1 + 2 (e + e² + … + e^{k−1})] = t₁ [1 + 2 e (1 − e^{k−1})/(1 − e)]
//     t_∞ = t₁ (1 + e)/(1 − e)                  at rest, after infinitely many; e < 1
//
// Each flight after an impact at v lasts 2 e v/g.
// Sign convention: heights and rebounds upwards, v_k a magnitude. Units: m, s.
// Source: elementary; the model case of accumulation in Brogliato, Nonsmooth Mechanics.
#pragma once

#include <cmath>
#include <limits>
#include <stdexcept>

namespace freeplay::reference {

struct BallImpact {
  double t;         ///< s
  double approach;  ///< m/s, downwards just before
  double rebound;   ///< m/s, upwards just after
};

struct BouncingBall {
  double height;       ///< m, > 0, at the release
  double gravity;      ///< m/s², > 0, downwards
  double restitution;  ///< in [0, 1]

  double first_time() const { return std::sqrt(2 * height / gravity); }
  /// e + e² + … + e^{count}, without cancellation for e near 1.
  double geometric(int count) const {
    const double e = restitution;
    if (e == 0 || count == 0) return 0;
    return e == 1 ? count : -e * std::expm1(count * std::log(e)) / (1 - e);
  }
};

/// The k-th impact, k ≥ 1.
inline BallImpact ball_impact(const BouncingBall& ball, int k) {
  if (k < 1) throw std::invalid_argument("ball_impact: impacts count from 1");
  const double t1 = ball.first_time();
  const double approach = ball.gravity * t1 * std::pow(ball.restitution, k - 1);
  return {t1 * (1 + 2 * ball.geometric(k - 1)), approach, ball.restitution * approach};
}

/// Time (s) from which the ball is at rest; infinite for e = 1.
inline double ball_accumulation_time(const BouncingBall& ball) {
  if (ball.restitution == 1) return std::numeric_limits<double>::infinity();
  return ball.first_time() * (1 + ball.restitution) / (1 - ball.restitution);
}

}  // namespace freeplay::reference
