// A block that falls on two frictionless corners (∓a, −b) from its centre of mass: height y and
// tilt θ.
//
//     m ÿ = −m g + Λ_A + Λ_B,        J θ̈ = w_A Λ_A + w_B Λ_B
//     g_k = y ∓ a sin θ − b cos θ ≥ 0,    w_k = ∂g_k/∂θ
//
// Free fall without rotation from rest brings corner A to the floor after √(2 d/g), where d is its
// height, with the speed √(2 g d) and the impulse (1 + e) √(2 g d)/(1/m + w_A²/J).
// Source: derived here. Parameters: Siconos, siconos-tutorials, examples/mechanics/RockingBlock/
// (RockingBlockED_NewMarkAlpha.cpp, RockingBlockED_Lsodar_LZBimpact.cpp, RockingBlockPlugin.cpp).
// The programs describe a block of 1 m × 0.5 m that stands on corner A at 60°. Their stored results
// have this inertia and start, but corners of a block of 0.2 m × 0.1 m. Units: kg, m, rad, s.
#pragma once

#include <numbers>

#include "verification/references/published/contact_events.hpp"

namespace freeplay::reference {

struct RockingBlock {
  static constexpr std::size_t coordinates = 2, contacts = 2;  ///< contacts: corners A, B
  using Vector = std::array<Long, 2>;
  Long half_width = 0.1L, half_height = 0.05L, inertia = 1.25L / 12, gravity = 9.81L;
  std::array<Long, 2> restitution{0.9L, 0.9L}, friction{};

  std::array<Vector, 2> mass(const Vector&) const { return {Vector{1, 0}, Vector{0, inertia}}; }
  Vector force(const Vector&, const Vector&) const { return {-gravity, 0}; }
  ContactRows<2> contact(std::size_t k, const Vector& q, const Vector& v) const {
    const Long side = k == 0 ? -half_width : half_width, c = std::cos(q[1]), s = std::sin(q[1]);
    ContactRows<2> rows;
    rows.gap = q[0] + side * s - half_height * c;
    rows.n = {1, side * c + half_height * s};
    rows.n_bias = (half_height * c - side * s) * v[1] * v[1];
    return rows;
  }
};

/// Height of the centre of mass of a block of 1 m × 0.5 m that stands on its corner at 60°.
inline Long rocking_height() { return std::sqrt(3.0L) / 4 + 0.125L; }

/// The impacts from rest at 60° up to `until` (s).
inline std::vector<PublishedImpact> rocking_block(const RockingBlock& block, Long until) {
  return impacts_until<RockingBlock>({block, {rocking_height(), std::numbers::pi_v<Long> / 3}, {0, 0}, 1e-3L},
                                     until);
}

/// The first impact in closed form, for corners above the floor.
inline PublishedImpact first_fall(const RockingBlock& block) {
  const auto rows = block.contact(0, {rocking_height(), std::numbers::pi_v<Long> / 3}, {});
  const Long speed = std::sqrt(2 * block.gravity * rows.gap), e = block.restitution[0];
  return {speed / block.gravity,
          0,
          -speed,
          e * speed,
          0,
          0,
          (1 + e) * speed / (1 + rows.n[1] * rows.n[1] / block.inertia),
          0};
}

/// RockingBlockED_Lsodar_LZBimpact.ref (commit e3d698e), e = 0.8: the first impact.
inline constexpr double published_fall = 0.3016807020283281;       // s
inline constexpr double published_fall_speed = 2.959487686897898;  // m/s
inline constexpr double published_rebound = 2.365312313096361;     // m/s, of the centre of mass

}  // namespace freeplay::reference
