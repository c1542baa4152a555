// A bearing of mass m₁ and a journal of mass m₂, free in the plane, radial clearance c, no
// friction. With e = r₂ − r₁, n = e/c at the wall, the restitution ε and m̄ = m₁ m₂/(m₁ + m₂):
//
//     flight     |e + ė τ| = c  →  τ = (c² − e·e)/(e·ė + √((e·ė)² + ė·ė (c² − e·e))),  e·ė ≥ 0
//                                  τ = (−e·ė + √(…))/ė·ė,  e·ė < 0
//     impact     P = (1 + ε) m̄ n·ė,     v₁⁺ = v₁ + P n/m₁,     v₂⁺ = v₂ − P n/m₂
//
// Sign convention: n from bearing centre to journal centre, gap rate = −n·ė; P > 0 pushes apart.
// Units: m, kg, s. Source: two-body reduction, any text of dynamics.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace freeplay::reference {

using Plane = std::array<double, 2>;

inline double dot(const Plane& a, const Plane& b) { return a[0] * b[0] + a[1] * b[1]; }

struct RingAndJournal {
  double bearing_mass;  ///< kg
  double journal_mass;  ///< kg
  double clearance;     ///< m, radial
  double restitution;   ///< in [0, 1]

  double reduced_mass() const { return bearing_mass * journal_mass / (bearing_mass + journal_mass); }
};

struct PairState {
  double t = 0;                                  ///< s
  Plane bearing{}, journal{};                    ///< m, centres
  Plane bearing_velocity{}, journal_velocity{};  ///< m/s

  Plane eccentricity() const { return {journal[0] - bearing[0], journal[1] - bearing[1]}; }
  Plane rate() const {
    return {journal_velocity[0] - bearing_velocity[0], journal_velocity[1] - bearing_velocity[1]};
  }
};

/// Time (s) until the journal next reaches the wall; none if the two have the same velocity. On the
/// wall itself and
/// moving inwards it is the time of the whole chord.
inline std::optional<double> time_to_contact(const Plane& e, const Plane& rate, double clearance) {
  const double a = dot(rate, rate), b = dot(e, rate), room = clearance * clearance - dot(e, e);
  if (a == 0) return std::nullopt;
  const double root = std::sqrt(std::fmax(0.0, b * b + a * room));
  return b >= 0 ? room / (b + root) : (root - b) / a;
}

inline PairState after_flight(PairState s, double tau) {
  s.t += tau;
  for (std::size_t i = 0; i < 2; ++i) {
    s.bearing[i] += tau * s.bearing_velocity[i];
    s.journal[i] += tau * s.journal_velocity[i];
  }
  return s;
}

struct PairImpact {
  PairState after;
  double impulse;   ///< N s
  double approach;  ///< m/s, n·ė before
};

/// The impact of a pair in contact, n·ė > 0.
inline PairImpact pair_impact(const RingAndJournal& pair, const PairState& before) {
  const Plane e = before.eccentricity();
  const double length = std::sqrt(dot(e, e));
  const Plane n{e[0] / length, e[1] / length};
  const double approach = dot(n, before.rate());
  const double m = pair.reduced_mass(), r = pair.restitution;
  PairImpact impact{before, (1 + r) * m * approach, approach};
  for (std::size_t i = 0; i < 2; ++i) {
    impact.after.bearing_velocity[i] += impact.impulse * n[i] / pair.bearing_mass;
    impact.after.journal_velocity[i] -= impact.impulse * n[i] / pair.journal_mass;
  }
  return impact;
}

}  // namespace freeplay::reference
