// Cases of Siconos with impacts: an oscillator at a wall in closed form; a pendulum between stops, a
// double pendulum at a wall, an impacting stick and a rocking block by contact_events.hpp.
//
// A point mass m on an isotropic spring of rate K in the field g against a wall x = 0, which the
// spring presses it to:
//
//     m ẍ = −K x − m g,    x ≥ 0,    ẋ⁺ = −e ẋ⁻;         m ÿ = −K y   (free along the wall)
//
// With ω² = K/m and c = g/ω² the flight that leaves the wall at v is x = −c + c cos ωt + (v/ω) sin
// ωt. It lasts (2/ω) atan(v/(ω c)) and returns with v. Released from rest at x₀, the mass arrives
// after acos(c/(c + x₀))/ω with √((2 c + x₀) x₀) ω. The rebounds e^n v₁ accumulate at a finite
// time, since a slow flight lasts 2 v/g.
// Source: derived here. Parameters: Siconos, siconos-tutorials,
// examples/mechanics/BouncingBallEventDriven/LinearOscillatorED.cpp. Units: kg, m, s.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "verification/references/published/contact_events.hpp"

namespace freeplay::reference {

struct OscillatorAtWall {
  long double mass = 1e-3L, stiffness = 100, gravity = 9.81L, restitution = 0.9L, x0 = 1, y0 = 1e-3L;

  struct Impact {
    long double t, approach, impulse;  ///< s, m/s, N s
  };
  long double omega() const { return std::sqrt(stiffness / mass); }
  long double sag() const { return gravity * mass / stiffness; }
  long double flight(long double v) const { return 2 / omega() * std::atan(v / (omega() * sag())); }

  /// The n-th impact, n ≥ 1.
  Impact impact(int n) const {
    long double t = std::acos(sag() / (sag() + x0)) / omega();
    long double v = omega() * std::sqrt((2 * sag() + x0) * x0);
    for (int k = 1; k < n; ++k) t += flight(v *= restitution);
    return {t, v, (1 + restitution) * mass * v};
  }
  /// Time at which the impacts accumulate: the flights after the n-th last 2 e v/(g (1 − e))
  /// together, up to a fraction (v/(ω c))²/3.
  long double accumulation() const {
    constexpr int many = 400;
    const auto last = impact(many);
    return last.t + 2 * restitution * last.approach / (gravity * (1 - restitution));
  }
  long double along_wall(long double t) const { return y0 * std::cos(omega() * t); }
};

/// Rows of LinearOscillatorED.ref (siconos-tutorials, commit 286a951): the times of two of its
/// impacts, the 92nd and the one after which it leaves the ball at rest.
inline constexpr double published_impact_92 = 0.8321809327194379;  // s
inline constexpr double published_rest = 0.8702795134611794;       // s

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
