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

#include <algorithm>
#include <cmath>
#include <optional>

#include "verification/references/numerics.hpp"

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

// A mass on a spring under a harmonic force, with Coulomb friction of a fixed bound F,
//
//     m ẍ = −k x + A sin(Ω t + φ) − F Sgn(ẋ),
//
// piecewise in closed form: in slip of direction s,
//
//     x = −s F/k + P sin(Ω t + φ) + C cos ω(t − t₀) + D sin ω(t − t₀),   P = A/(m (ω² − Ω²)),
//
// until ẋ = 0; then rest until |−k x + A sin(Ω t + φ)| exceeds F. Roots are bracketed by steps of a
// thousandth of the shorter period and bisected to rounding.

struct FrictionOscillator {
  double m = 1, k = 1, bound = 1, amplitude = 1, omega = 1, phase = 0;
  struct State {
    double t = 0, x = 0, v = 0;
    int sticks = 0;
  };

  double force(double t, double x) const { return -k * x + amplitude * std::sin(omega * t + phase); }

  State at(double end, State s) const {
    const double w = std::sqrt(k / m), dt = 2e-3 * M_PI / std::max(w, omega);
    const double P = amplitude / m / (w * w - omega * omega);
    while (s.t < end) {
      if (s.v == 0 && std::abs(force(s.t, s.x)) <= bound * (1 + 1e-13)) {
        ++s.sticks;
        const auto until = fall([&](double t) { return bound - std::abs(force(t, s.x)); }, s.t, 0, dt, end);
        s.t = until.value_or(end);
        if (!until) break;
        s.t += 1e-9 * dt;  // beyond the limit, by an error in x of its third power
      }
      const int way = s.v != 0 ? (s.v > 0 ? 1 : -1) : force(s.t, s.x) > 0 ? 1 : -1;
      const double shift = -way * bound / k, t0 = s.t, C = s.x - shift - P * std::sin(omega * t0 + phase),
                   D = (s.v - P * omega * std::cos(omega * t0 + phase)) / w;
      const auto x = [&](double t) {
        return shift + P * std::sin(omega * t + phase) + C * std::cos(w * (t - t0)) +
               D * std::sin(w * (t - t0));
      };
      const auto v = [&](double t) {
        return P * omega * std::cos(omega * t + phase) +
               w * (D * std::cos(w * (t - t0)) - C * std::sin(w * (t - t0)));
      };
      // From rest, the speed rises as t² or faster, which rounding hides in the first thousandth.
      const auto stop = fall([&](double t) { return way * v(t); }, t0, s.v == 0 ? 1e-3 * dt : dt, dt, end);
      s.t = stop.value_or(end);
      s.x = x(s.t);
      s.v = stop ? 0 : v(s.t);
    }
    return s;
  }

 private:
  /// The first time after from + first at which a value that is positive before falls below zero.
  template <class F>
  static std::optional<double> fall(const F& f, double from, double first, double dt, double end) {
    for (double a = from + first; a < end; a += dt) {
      double lo = a, hi = std::min(a + dt, end);
      if (f(hi) >= 0) continue;
      bisect(lo, hi, 80, [&](double x) { return f(x) >= 0; });
      return hi;
    }
    return {};
  }
};

}  // namespace freeplay::reference
