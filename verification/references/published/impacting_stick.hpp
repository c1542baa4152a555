// A slender rod that falls on one end, with friction: x, y of its centre and the angle θ from the
// vertical; lower end x + (l/2) sin θ, y − (l/2) cos θ.
//
//     m ẍ = Λ_T,   m ÿ = −m g + Λ_N,   (m l²/12) θ̈ = (l/2) (Λ_N sin θ + Λ_T cos θ)
//
// elastic_impact() is the limit of a stiff elastic contact with Coulomb friction, which can reverse
// its sliding during the impact: the rates change with the normal impulse p by
//
//     dv_N/dp = D_NN − s μ D_NT,    dv_T/dp = D_NT − s μ D_TT,    s = sgn v_T
//
// until the work ∫ v_N dp of the normal impulse is zero (Routh 1905; Stronge, Impact Mechanics,
// 2000, with e* = 1).
// Source: derived here. Parameters: Siconos, siconos-tutorials, examples/mechanics/ImpactingStick/
// (ImpactingStick.cpp, ImpactingStickPlugin.cpp). Units: kg, m, s.
#pragma once

#include <numbers>

#include "verification/references/published/contact_events.hpp"

namespace freeplay::reference {

struct ImpactingStick {
  static constexpr std::size_t coordinates = 3, contacts = 1;
  using Vector = std::array<Long, 3>;
  Long rod_mass = 1, length = 1, gravity = 10;
  std::array<Long, 1> restitution{1}, friction{0.01L};

  Long inertia() const { return rod_mass * length * length / 12; }
  std::array<Vector, 3> mass(const Vector&) const {
    return {Vector{rod_mass, 0, 0}, Vector{0, rod_mass, 0}, Vector{0, 0, inertia()}};
  }
  Vector force(const Vector&, const Vector&) const { return {0, -rod_mass * gravity, 0}; }
  ContactRows<3> contact(std::size_t, const Vector& q, const Vector& v) const {
    const Long c = length / 2 * std::cos(q[2]), s = length / 2 * std::sin(q[2]);
    return {q[1] - c, {0, 1, s}, {1, 0, c}, c * v[2] * v[2], -s * v[2] * v[2]};
  }
};

/// The published start: tilted by 45°, the lower end 0.01 m above the floor.
inline ContactEvents<ImpactingStick> impacting_stick() {
  const Long a = std::numbers::pi_v<Long> / 4;
  return {ImpactingStick{}, {std::sin(a) / 2, std::cos(a) / 2 + 0.01L, a}, {-0.5L, 0.1L, 0.1L}, 1e-3L};
}

/// The elastic impact of the lower end at the tilt `angle` from the rates v_n < 0 and v_t < 0.
inline PublishedImpact elastic_impact(const ImpactingStick& rod, Long angle, Long v_n, Long v_t) {
  const auto row = rod.contact(0, {0, 0, angle}, {});
  const Long J = rod.inertia(), m = rod.rod_mass, mu = rod.friction[0];
  const Long nn = 1 / m + row.n[2] * row.n[2] / J, nt = row.n[2] * row.t[2] / J,
             tt = 1 / m + row.t[2] * row.t[2] / J;
  PublishedImpact done{0, 0, v_n, v_n, v_t, v_t, 0, 0};
  // First phase: sliding backwards, friction +μ. It ends where the sliding stops.
  const Long stop = -v_t / (nt + mu * tt);
  done.v_n_plus += (nn + mu * nt) * stop;
  const Long work = (v_n + done.v_n_plus) / 2 * stop;
  // Second phase: friction −μ; dv_T/dp = nt − μ tt > 0 moves the end forwards. Its normal impulse p
  // brings the work to zero: work + v p + D p²/2 = 0.
  const Long slope = nn - mu * nt, v = done.v_n_plus;
  const Long p = (-v + std::sqrt(v * v - 2 * slope * work)) / slope;
  done.v_n_plus += slope * p, done.v_t_plus = (nt - mu * tt) * p;
  done.impulse_n = stop + p, done.impulse_t = mu * (stop - p);
  return done;
}

}  // namespace freeplay::reference
