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

}  // namespace freeplay::reference
