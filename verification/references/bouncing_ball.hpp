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
#include <optional>
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

// A disc that flies straight towards a fixed disc: time and speed of first contact, in closed form.
// The root is evaluated without cancellation. No solver is included here.

struct Throw {
  double x, y;    ///< m, of the disc's centre from the peg's, at t = 0
  double vx, vy;  ///< m/s
  double reach;   ///< m, sum of the radii
};

struct PegTouch {
  double t;         ///< s
  double approach;  ///< m/s, > 0
};

/// |p + v t| = reach; none if the path misses the peg.
inline std::optional<PegTouch> touch_of(const Throw& s) {
  const double speed = std::hypot(s.vx, s.vy), along = -(s.x * s.vx + s.y * s.vy) / speed;
  const double off = (s.x * s.vy - s.y * s.vx) / speed;
  if (!(std::abs(off) < s.reach) || along < 0) return std::nullopt;
  const double half = std::sqrt((s.reach - off) * (s.reach + off));  // half the chord
  // The distance to first contact, along − half = (|p|² − reach²)/(along + half).
  const double far = s.x * s.x + s.y * s.y - s.reach * s.reach;
  return PegTouch{far / (along + half) / speed, speed * half / s.reach};
}

/// A rotor driven by one torque pulse per revolution: its speed after n of them, ½ J ω² = ½ J
/// ω₀² + n W.
inline double speed_after_pulses(double omega, double inertia, double work, int n) {
  return std::sqrt(omega * omega + 2 * n * work / inertia);
}
/// Number of pulses by t, at `first` (rad) and each revolution after it, from angle 0; each without
/// duration.
inline int pulses_by(double t, double omega, double inertia, double work, double first) {
  double angle = first;
  for (int n = 0;; ++n, angle = 2 * M_PI) {
    t -= angle / speed_after_pulses(omega, inertia, work, n);
    if (t < 0) return n;
  }
}

}  // namespace freeplay::reference
