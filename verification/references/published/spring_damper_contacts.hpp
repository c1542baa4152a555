// A mass above a floor with a linear spring and damper, under gravity. With the gap x above the
// floor and F the force of the floor on the mass,
//
//     m ẍ = −m g + F,      F = 0 for x > 0,      F = −k x − d ẋ for x < 0
//
// where F either never pulls, F ≥ 0 (the contact then ends at F = 0, before x = 0), or may pull
// until x = 0. Flights are parabolas. In contact, with ω² = k/m, ζ = d/(2 √(k m)) < 1,
// Ω = ω √(1 − ζ²) and the rest position x_s = −m g/k,
//
//     x = x_s + e^{−ζωt} (A cos Ωt + B sin Ωt),   A = x₀ − x_s,   B = (ẋ₀ + ζω A)/Ω .
//
// The end of a contact is a root of F or of x, found by bisection; nothing is integrated. Units:
// m, kg, s. Source: damped oscillator, by hand.
#pragma once

#include <cmath>
#include <stdexcept>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

struct LinearContact {
  using Real = long double;
  Real mass, stiffness, damping, gravity;
  bool pulls = false;  ///< whether the floor may pull until the gap opens

  struct State {
    Real gap, rate;  ///< m, m/s
    int impacts = 0;
  };

  /// State at the time t (s), from a start in flight.
  State at(Real t, State s) const {
    for (;;) {
      const Real fall = (s.rate + std::sqrt(s.rate * s.rate + 2 * gravity * s.gap)) / gravity;
      if (fall >= t) return flight(s, t);
      s = flight(s, fall);
      s.gap = 0;
      t -= fall;
      ++s.impacts;
      const Real end = contact_end(s);
      if (end >= t) return contact(s, t);
      s = contact(s, end);
      t -= end;
      if (pulls) s.gap = 0;
      if (s.gap < 0) {  // without force up to the gap 0
        const Real root = s.rate * s.rate + 2 * gravity * s.gap;
        if (root <= 0) throw std::domain_error("LinearContact: comes to rest");
        const Real rise = -2 * s.gap / (s.rate + std::sqrt(root));
        if (rise >= t) return flight(s, t);
        s = flight(s, rise);
        s.gap = 0;
        t -= rise;
      }
    }
  }

 private:
  State flight(State s, Real t) const {
    return {s.gap + s.rate * t - gravity * t * t / 2, s.rate - gravity * t, s.impacts};
  }
  Real omega() const { return std::sqrt(stiffness / mass); }
  Real zeta() const { return damping / (2 * std::sqrt(stiffness * mass)); }
  Real damped() const { return omega() * std::sqrt(1 - zeta() * zeta()); }
  State contact(State s, Real t) const {
    const Real rest = -mass * gravity / stiffness, decay = zeta() * omega(), W = damped();
    const Real a = s.gap - rest, b = (s.rate + decay * a) / W;
    const Real c = std::cos(W * t), n = std::sin(W * t), f = std::exp(-decay * t);
    return {rest + f * (a * c + b * n), f * ((b * W - decay * a) * c - (a * W + decay * b) * n), s.impacts};
  }
  /// Time after onset at which the force vanishes or, if the floor may pull, the gap opens.
  Real contact_end(State s) const {
    const auto inside = [&](Real t) {
      const auto q = contact(s, t);
      return (pulls ? q.gap : stiffness * q.gap + damping * q.rate) < 0;
    };
    const Real step = 0.01L * std::acos(-1.0L) / damped();
    Real low = step, high = 2 * step;
    for (; inside(high); low = high, high += step)
      if (high > 400 * step) throw std::domain_error("LinearContact: stays closed");
    bisect(low, high, 80, [&](Real middle) { return inside(middle); });
    return high;
  }
};

/// TestModels/contactCoordinateTest.py of Exudyn: released at rest 0.05 m above contact; 0.25 s.
inline LinearContact exudyn_contact_coordinate(bool pulls) { return {0.25L, 2e6L, 200, 9.81L, pulls}; }
inline constexpr LinearContact::State exudyn_contact_coordinate_start{0.05L, 0};

/// TestModels/postNewtonStepContactTest.py of Exudyn: at 1 m/s downwards from 0.01 m; 0.5 s.
inline LinearContact exudyn_post_newton() { return {0.25L, 20000, 0, 9.81L}; }
inline constexpr LinearContact::State exudyn_post_newton_start{0.01L, -1};

inline constexpr long double exudyn_radius = 0.05L;  ///< m: its position is the gap plus this

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
