// Teeth, slots and stops in closed form, and gears whose centres an arm carries.
//
// Two external gears with base radii r₁, r₂ and inertias J₁, J₂ touch along their line of action;
// their effective mass there is m, 1/m = r₁²/J₁ + r₂²/J₂. With backlash b, in the middle of the
// backlash at t = 0, restitution e and closing speed u = r₁ ω₁ + r₂ ω₂ > 0 they rattle, without
// other forces, alternately on either flank (side s = +1, −1, …):
//
//     t₁ = b/(2u),   t_{k+1} = t_k + b/(e^k u),   P_k = (1 + e) m e^{k−1} u,
//     Δω₁ = −s r₁ P/J₁,   Δω₂ = −s r₂ P/J₂
//
// Involute teeth at the distance a: inv α = tan α − α, cos α = (r₁ + r₂)/a. A point that moves at
// the speed v between two stops bounces likewise. Units: m, s, rad, kg. Sources: Newton's impact
// law; ISO 21771-1:2007 for the involute.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "verification/references/numerics.hpp"
#include "verification/references/published/contact_events.hpp"

namespace freeplay::reference {

struct BounceImpact {
  double t, approach, impulse;
};

/// Impacts between two walls: the first at a distance `near`, then `width` apart.
inline std::vector<BounceImpact> bounces(double near, double width, double speed, double e, double mass,
                                         int count) {
  std::vector<BounceImpact> list;
  double t = near / speed;
  for (int k = 0; k < count; ++k) {
    list.push_back({t, speed, (1 + e) * mass * speed});
    speed *= e;
    t += width / speed;
  }
  return list;
}

struct GearPair {
  double J1, J2, r1, r2;  ///< r: base radii
  double mass() const { return 1 / (r1 * r1 / J1 + r2 * r2 / J2); }
};

/// (r₁ + r₂) inv α at the distance a.
inline long double involute(long double sum, long double a) {
  const long double alpha = std::acos(sum / a);
  return sum * (std::tan(alpha) - alpha);
}

/// First time from 0 at which a slotted body touches the pin of a crank again, after it separated
/// from the pin tangentially and moves uniformly: the root in (0, until), whichever is first, of
/// y(t) = r cos(φ + ω t) − r cos φ + r ω sin φ t + c or − c.
inline double pin_flight(double r, double omega, double phi, double c, double until) {
  const auto y = [&](double t) {
    return std::abs(r * (std::cos(phi + omega * t) - std::cos(phi) + omega * std::sin(phi) * t)) - c;
  };
  double low = 0, high = until;
  bisect(low, high, 200, [&](double mid) { return y(mid) < 0; });
  return 0.5 * (low + high);
}

// Two external gears with backlash whose centres an arm carries. The arm swings about a fixed pivot;
// the centres lie on its axis at p₁ < p₂, so that both move and the line of action turns with the
// arm. Angles: θ of the arm from the x axis, φ₁, φ₂ of the gears; gravity g along −y.
//
//     J θ̈ = −g (m_a c + m₁ p₁ + m₂ p₂) cos θ,   J = J_a + m_a c² + m₁ p₁² + m₂ p₂²,   φ̈₁ = φ̈₂ = 0
//     gap of flank σ = ±1   g_σ = b/2 + σ (S θ − r₁ φ₁ − r₂ φ₂ − C),   S = r₁ + r₂
//     impact                P = (1 + e) m |ġ_σ|,   1/m = S²/J + r₁²/J₁ + r₂²/J₂
//                           Δ(θ̇, φ̇₁, φ̇₂) = σ P (S/J, −r₁/J₁, −r₂/J₂)
//
// r are base radii, b is the backlash at the standard distance p₂ − p₁, C centres the teeth at the
// start. Written from Lagrange's equations in three coordinates; `ContactEvents` follows the motion.
// Units: m, kg, s, rad. Source: ISO 21771-1:2007 for the involute; Newton's impact law.

struct GearsOnArm {
  static constexpr std::size_t coordinates = 3, contacts = 2;  ///< θ, φ₁, φ₂; flanks +1, −1
  using Vector = std::array<Long, 3>;
  Long arm_mass, arm_inertia, arm_centre;  ///< kg, kg m² about the centre of mass, m from the pivot
  std::array<Long, 2> gear_mass, inertia, base, place;  ///< of the gears; base radii, p₁ and p₂
  Long backlash, gravity, centred;                      ///< `centred`: θ at the start, where φ = 0
  std::array<Long, 2> restitution, friction{};

  std::array<Vector, 3> mass(const Vector& /*q*/) const {
    const Long J = arm_inertia + arm_mass * arm_centre * arm_centre + gear_mass[0] * place[0] * place[0] +
                   gear_mass[1] * place[1] * place[1];
    return {Vector{J, 0, 0}, Vector{0, inertia[0], 0}, Vector{0, 0, inertia[1]}};
  }
  Vector force(const Vector& q, const Vector& /*v*/) const {
    const Long moment = arm_mass * arm_centre + gear_mass[0] * place[0] + gear_mass[1] * place[1];
    return {-gravity * moment * std::cos(q[0]), 0, 0};
  }
  ContactRows<3> contact(std::size_t k, const Vector& q, const Vector& /*v*/) const {
    const Long side = k == 0 ? 1 : -1, S = base[0] + base[1];
    const Vector n{side * S, -side * base[0], -side * base[1]};
    return {.gap = backlash / 2 - n[0] * centred + product(n, q), .n = n};
  }
};

}  // namespace freeplay::reference
