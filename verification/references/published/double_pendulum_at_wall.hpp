// A double pendulum of two point masses on massless rods, at a vertical wall through its pivot.
// With the angles q₀, q₁ of the rods from the downward vertical
//
//     (m₁ + m₂) l₁ q̈₀ + m₂ l₂ cos(q₀ − q₁) q̈₁ = −m₂ l₂ sin(q₀ − q₁) q̇₁² − (m₁ + m₂) g sin q₀
//     l₁ cos(q₀ − q₁) q̈₀ + l₂ q̈₁             =     l₁ sin(q₀ − q₁) q̇₀² − g sin q₁
//     l₁ sin q₀ ≥ 0 (upper mass, e = 1),       l₁ sin q₀ + l₂ sin q₁ ≥ 0 (lower mass, e = 0)
//
// Here m₁ = m₂ = 1 kg and l₁ = l₂ = 1 m.
// Source: Lagrange's equations, derived here. Parameters: Siconos, siconos-tutorials,
// examples/mechanics/Pendulum/ (DoublePendulumTS.cpp, DoublePendulumPlugin.cpp). Units: kg, m, rad,
// s.
#pragma once

#include "verification/references/published/contact_events.hpp"

namespace freeplay::reference {

struct DoublePendulumAtWall {
  static constexpr std::size_t coordinates = 2, contacts = 2;  ///< contacts: upper, lower mass
  using Vector = std::array<Long, 2>;
  Long gravity = 10;
  std::array<Long, 2> restitution{1, 0}, friction{};

  std::array<Vector, 2> mass(const Vector& q) const {
    const Long c = std::cos(q[0] - q[1]);
    return {Vector{2, c}, Vector{c, 1}};
  }
  Vector force(const Vector& q, const Vector& v) const {
    const Long s = std::sin(q[0] - q[1]);
    return {-s * v[1] * v[1] - 2 * gravity * std::sin(q[0]), s * v[0] * v[0] - gravity * std::sin(q[1])};
  }
  ContactRows<2> contact(std::size_t k, const Vector& q, const Vector& v) const {
    ContactRows<2> rows;
    for (std::size_t i = 0; i <= k; ++i) {
      rows.gap += std::sin(q[i]);
      rows.n[i] = std::cos(q[i]);
      rows.n_bias -= std::sin(q[i]) * v[i] * v[i];
    }
    return rows;
  }
};

/// The impacts of the published start at rest, q₀ = 0.1 and q₁ = 0.2, up to `until` (s).
inline std::vector<PublishedImpact> double_pendulum_at_wall(Long until) {
  return impacts_until<DoublePendulumAtWall>({{}, {0.1L, 0.2L}, {0, 0}, 1e-3L}, until);
}

}  // namespace freeplay::reference
