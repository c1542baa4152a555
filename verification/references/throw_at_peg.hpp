// A disc that flies straight towards a fixed disc: time and speed of first contact, in closed form.
// The root is evaluated without cancellation. No solver is included here.
#pragma once

#include <cmath>
#include <optional>

namespace freeplay::reference {

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
