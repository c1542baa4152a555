// A slider on a frictionless rail between two stops, with a pendulum: a point mass on a massless
// rod. With the slider's place x and the rod's angle θ from the downward vertical
//
//     (m₁ + m₂) ẍ + m₂ l cos θ θ̈ = m₂ l θ̇² sin θ
//     cos θ ẍ + l θ̈ = −g sin θ
//     upper − x ≥ 0,    x − lower ≥ 0,    Newton's restitution e at both stops
//
// Source: Lagrange's equations, derived here; the second is divided by m₂ l and is multiplied by it
// in mass() and force(). Parameters: Siconos, siconos-tutorials,
// examples/mechanics/PendulumOnASlider/ (PendulumAttachedToSlider.cpp, PendulumPlugin.cpp). Units:
// kg, m, rad, s.
#pragma once

#include "verification/references/published/contact_events.hpp"

namespace freeplay::reference {

struct PendulumBetweenStops {
  static constexpr std::size_t coordinates = 2, contacts = 2;  ///< contacts: upper, lower stop
  using Vector = std::array<Long, 2>;
  Long slider = 1, bob = 1, length = 1, gravity = 9.81L, lower = 0.0125L, upper = 0.2375L;
  std::array<Long, 2> restitution{0.5L, 0.5L}, friction{};

  std::array<Vector, 2> mass(const Vector& q) const {
    const Long coupling = bob * length * std::cos(q[1]);
    return {Vector{slider + bob, coupling}, Vector{coupling, bob * length * length}};
  }
  Vector force(const Vector& q, const Vector& v) const {
    const Long s = bob * length * std::sin(q[1]);
    return {s * v[1] * v[1], -s * gravity};
  }
  ContactRows<2> contact(std::size_t k, const Vector& q, const Vector&) const {
    ContactRows<2> rows;
    rows.gap = k == 0 ? upper - q[0] : q[0] - lower;
    rows.n[0] = k == 0 ? -1 : 1;
    return rows;
  }
};

/// The impacts of the published start x = θ = 0.1, ẋ = 2 m/s, θ̇ = 0 up to `until` (s).
inline std::vector<PublishedImpact> pendulum_between_stops(Long until) {
  return impacts_until<PendulumBetweenStops>({{}, {0.1L, 0.1L}, {2, 0}, 2e-3L}, until);
}

}  // namespace freeplay::reference
