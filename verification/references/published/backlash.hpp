// A rotor (inertia J_r, angle θ_r) drives a load (J_l, θ_l; locked: infinite) through backlash of
// the half-width b. With δ = θ_r − θ_l, its rate ω, the depth y = |δ| − b > 0 and its rate ẏ, the
// couple of the teeth never pulls:
//
//     T = max(0, k y + c ẏ) sgn δ,     δ̈ = τ(t)/J_r − T/J,     1/J = 1/J_r + 1/J_l,
//     τ = A sin W t .
//
// Without T, δ is uniform motion plus the sine integrated twice. With T, y is a damped oscillation,
// ω₀² = k/J, ζ = c/(2 √(k J)) < 1, plus the forced response to the sine. Contact begins at y = 0,
// ends where k y + c ẏ = 0 (or y = 0), and begins anew if k y + c ẏ becomes positive beyond b.
// These instants are found by scanning at a hundredth of the period 2π/ω₀ and bisection; nothing is
// integrated. The load follows from the sum of momenta, J_r θ̇_r + J_l θ̇_l = ∫ τ dt.
//
// Undriven, every contact multiplies the speed by the same e. With φ = atan2(2ζ √(1 − ζ²), 2ζ² − 1)
// in (0, π), the contact lasts φ/(ω₀ √(1 − ζ²)) and e = exp(−ζ φ/√(1 − ζ²)).
//
// Source of e: T. Schwager, T. Pöschel, Granular Matter 9 (2007) 465; by hand otherwise.
// Parameters: the actuator of google-deepmind/mujoco issue 3468 (2026), rotor inertia 0.01 kg m²,
// half-width 0.05 rad, 1e4 N m/rad, 2 N m s/rad. Units: rad, s, kg m², N m.
#pragma once

#include <cmath>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

struct Backlash {
  using Real = long double;
  Real rotor = 0.01L, load = INFINITY, half = 0.05L, stiffness = 1e4L, damping = 2;
  Real amplitude = 0, frequency = 0;  ///< A (N m) and W (rad/s)

  struct State {
    Real t, delta, omega;
    int contacts = 0;
  };

  Real inertia() const { return 1 / (1 / rotor + 1 / load); }
  Real natural() const { return std::sqrt(stiffness / inertia()); }
  Real zeta() const { return damping / (2 * std::sqrt(stiffness * inertia())); }
  /// Speed after over before a contact without a drive.
  Real restitution() const { return std::exp(-zeta() * phase() / root()); }

  State at(Real end, State s) const {
    enum class Mode { gap, loaded, unloaded } mode = Mode::gap;
    const Real longest = 0.01L * 2 * std::acos(-1.0L) / natural();
    while (s.t < end) {
      const auto go = [&](Real h) { return mode == Mode::loaded ? contact(s, h) : flight(s, h); };
      const auto over = [&](const State& q) {
        const Real side = q.delta < 0 ? -1 : 1, y = side * q.delta - half;
        const Real couple = stiffness * y + damping * side * q.omega;
        if (mode == Mode::gap) return y > 0;
        return mode == Mode::loaded ? y < 0 || couple < 0 : y < 0 || couple > 0;
      };
      Real h = std::fmin(longest, end - s.t);
      if (!over(go(h))) {
        s = go(h);
        continue;
      }
      Real low = 0;
      bisect(low, h, 80, [&](Real middle) { return !over(go(middle)); });
      s = go(h);
      const Real side = s.delta < 0 ? -1 : 1;
      const bool inside = mode != Mode::gap && side * s.delta - half <= 0;
      if (mode == Mode::gap) ++s.contacts;
      mode =
          mode == Mode::loaded ? (inside ? Mode::gap : Mode::unloaded) : (inside ? Mode::gap : Mode::loaded);
      // beyond rounding
      s.delta += inside ? -1e-18L * side : mode == Mode::loaded ? 1e-18L * side : 0;
    }
    return s;
  }

  /// Rates and angles of rotor and load, both at rest at 0 at the start, from δ and ω.
  struct Bodies {
    Real rotor_angle, rotor_rate, load_angle, load_rate;
  };
  Bodies bodies(const State& s) const {
    const Real w = frequency, sum = rotor + load;
    const Real momentum = amplitude / w * (1 - std::cos(w * s.t));
    const Real moved = amplitude / w * (s.t - std::sin(w * s.t) / w);
    return {(moved + load * s.delta) / sum, (momentum + load * s.omega) / sum,
            (moved - rotor * s.delta) / sum, (momentum - rotor * s.omega) / sum};
  }

 private:
  Real root() const { return std::sqrt(1 - zeta() * zeta()); }
  Real phase() const { return std::atan2(2 * zeta() * root(), 2 * zeta() * zeta() - 1); }
  State flight(const State& s, Real h) const {
    const Real w = frequency, a = amplitude / rotor, t = s.t + h;
    if (a == 0) return {t, s.delta + s.omega * h, s.omega, s.contacts};
    const Real rate = s.omega + a / w * std::cos(w * s.t);
    return {t, s.delta + rate * h - a / (w * w) * (std::sin(w * t) - std::sin(w * s.t)),
            rate - a / w * std::cos(w * t), s.contacts};
  }
  State contact(const State& s, Real h) const {
    const Real side = s.delta < 0 ? -1 : 1, w = frequency, n = natural(), d = zeta() * n, W = n * root();
    // Forced response p sin wt + q cos wt of y.
    const Real a = side * amplitude / rotor, u = n * n - w * w, v = 2 * d * w, m = u * u + v * v;
    const Real p = a * u / m, q = -a * v / m;
    const auto forced = [&](Real t) { return p * std::sin(w * t) + q * std::cos(w * t); };
    const auto forced_rate = [&](Real t) { return w * (p * std::cos(w * t) - q * std::sin(w * t)); };
    const Real y = side * s.delta - half - forced(s.t), r = side * s.omega - forced_rate(s.t);
    const Real b = (r + d * y) / W, c = std::cos(W * h), z = std::sin(W * h), f = std::exp(-d * h),
               t = s.t + h;
    return {t, side * (half + f * (y * c + b * z) + forced(t)),
            side * (f * ((b * W - d * y) * c - (y * W + d * b) * z) + forced_rate(t)), s.contacts};
  }
};

/// The rotor against a locked load, from the middle of the backlash at 10 rad/s.
inline constexpr Backlash backlash_free{};
inline constexpr Backlash::State backlash_free_start{0, 0, 10};
/// The rotor driven by 5 sin(2π 10 t) N m, with a load of 0.05 kg m², both at rest.
inline Backlash backlash_driven() {
  Backlash b;
  b.load = 0.05L, b.amplitude = 5, b.frequency = 20 * std::acos(-1.0L);
  return b;
}
inline constexpr Backlash::State backlash_driven_start{0, 0, 0};

}  // namespace freeplay::reference
