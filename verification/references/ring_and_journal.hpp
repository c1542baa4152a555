// A bearing of mass m₁ and a journal of mass m₂, free in the plane, radial clearance c, no
// friction. With e = r₂ − r₁, n = e/c at the wall, the restitution ε and m̄ = m₁ m₂/(m₁ + m₂):
//
//     flight     |e + ė τ| = c  →  τ = (c² − e·e)/(e·ė + √((e·ė)² + ė·ė (c² − e·e))),  e·ė ≥ 0
//                                  τ = (−e·ė + √(…))/ė·ė,  e·ė < 0
//     impact     P = (1 + ε) m̄ n·ė,     v₁⁺ = v₁ + P n/m₁,     v₂⁺ = v₂ − P n/m₂
//     loss       ½ m̄ (1 − ε²) (n·ė)²
//
// From wall to wall the journal runs along chords: with the normal speed w and the tangential speed
// u after an impact, the chord takes 2 c w/(w² + u²) and turns n by 2 atan2(w, u). At each impact w
// is multiplied by ε and u is unchanged, the force being central (relative angular momentum m̄
// e × ė).
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
inline double cross(const Plane& a, const Plane& b) { return a[0] * b[1] - a[1] * b[0]; }

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
  double impulse;      ///< N s
  double approach;     ///< m/s, n·ė before
  double energy_lost;  ///< J
};

/// The impact of a pair in contact, n·ė > 0.
inline PairImpact pair_impact(const RingAndJournal& pair, const PairState& before) {
  const Plane e = before.eccentricity();
  const double length = std::sqrt(dot(e, e));
  const Plane n{e[0] / length, e[1] / length};
  const double approach = dot(n, before.rate());
  const double m = pair.reduced_mass(), r = pair.restitution;
  PairImpact impact{before, (1 + r) * m * approach, approach, 0.5 * m * (1 - r * r) * approach * approach};
  for (std::size_t i = 0; i < 2; ++i) {
    impact.after.bearing_velocity[i] += impact.impulse * n[i] / pair.bearing_mass;
    impact.after.journal_velocity[i] -= impact.impulse * n[i] / pair.journal_mass;
  }
  return impact;
}

struct PairLedger {
  Plane momentum;           ///< kg m/s
  double angular_momentum;  ///< kg m²/s, about the origin
  double energy;            ///< J
};

inline PairLedger pair_ledger(const RingAndJournal& pair, const PairState& s) {
  const double m1 = pair.bearing_mass, m2 = pair.journal_mass;
  const Plane &v1 = s.bearing_velocity, &v2 = s.journal_velocity;
  return {{m1 * v1[0] + m2 * v2[0], m1 * v1[1] + m2 * v2[1]},
          m1 * cross(s.bearing, v1) + m2 * cross(s.journal, v2),
          0.5 * (m1 * dot(v1, v1) + m2 * dot(v2, v2))};
}

/// From wall to wall: w and u (m/s) the inward and the tangential speed after an impact.
struct Chord {
  double duration;  ///< s
  double turn;      ///< rad, of n, in the direction of u
};
inline Chord chord(double clearance, double w, double u) {
  return {2 * clearance * w / (w * w + u * u), 2 * std::atan2(w, std::abs(u))};
}

}  // namespace freeplay::reference
