// A block on a slope of inclination α with Coulomb friction μ and the initial velocity v₀ along it:
//
//     moving up       s̈ = −g (sin α + μ cos α)      stops at t_s = v₀/|s̈|,  s_s = v₀²/(2|s̈|)
//     moving down     s̈ = −g (sin α − μ cos α)      stops only if μ > tan α, at t_s = |v₀|/s̈
//     at rest         sticks if tan α ≤ μ, held by g sin α; otherwise slides down
//
// Sign convention: s, v, friction positive up the slope; 0 ≤ α < π/2. Units: m, s, rad; friction as
// force over mass, m/s².
// Source: Coulomb's law F_T ∈ −μ F_N Sgn(v) with F_N = m g cos α; any text of statics.
#pragma once

#include <cmath>
#include <optional>

namespace freeplay::reference {

struct BlockOnSlope {
  double inclination;  ///< α, rad, in [0, π/2)
  double friction;     ///< μ, ≥ 0
  double gravity;      ///< m/s², > 0
  double velocity;     ///< v₀, m/s, positive up the slope

  double pull() const { return gravity * std::sin(inclination); }
  double grip() const { return friction * gravity * std::cos(inclination); }
  /// Whether a block at rest sticks.
  bool sticks() const { return pull() <= grip(); }
  /// s̈ (m/s²) while moving up (direction > 0) or down (direction < 0).
  double acceleration(int direction) const { return -pull() - (direction > 0 ? grip() : -grip()); }
};

struct BlockState {
  double position;      ///< m, from the start, positive up the slope
  double velocity;      ///< m/s
  double acceleration;  ///< m/s², of the phase that begins or continues at this time
  double friction;      ///< m/s², friction force over mass
};

/// First instant of rest (s); none if the block never comes to rest. A block that starts at rest
/// stops at 0.
inline std::optional<double> block_stopping_time(const BlockOnSlope& b) {
  if (b.velocity == 0) return 0.0;
  const double a = b.acceleration(b.velocity > 0 ? 1 : -1);
  if (a * b.velocity >= 0) return std::nullopt;
  return -b.velocity / a;
}

/// Distance (m, ≥ 0) covered up to the first instant of rest; none if there is none.
inline std::optional<double> block_stopping_distance(const BlockOnSlope& b) {
  if (b.velocity == 0) return 0.0;
  const double a = b.acceleration(b.velocity > 0 ? 1 : -1);
  if (a * b.velocity >= 0) return std::nullopt;
  return b.velocity * b.velocity / (2 * std::abs(a));
}

/// State at the time t ≥ 0 (s).
inline BlockState block_state(const BlockOnSlope& b, double t) {
  const std::optional<double> stop = block_stopping_time(b);
  if (!stop || t < *stop) {
    const double a = b.acceleration(b.velocity > 0 ? 1 : -1);
    return {t * (b.velocity + 0.5 * a * t), b.velocity + a * t, a, a + b.pull()};
  }
  const double way = *block_stopping_distance(b);
  const double top = b.velocity < 0 ? -way : way;
  if (b.sticks()) return {top, 0, 0, b.pull()};
  const double a = b.acceleration(-1), tau = t - *stop;
  return {top + 0.5 * a * tau * tau, a * tau, a, b.grip()};
}

}  // namespace freeplay::reference
