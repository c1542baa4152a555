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
// start. Flights are integrated by steps of order 8, and an impact is bisected on the length of the
// step. Written from Lagrange's equations in three coordinates; it shares nothing with the program.
// Units: m, kg, s, rad. Source: ISO 21771-1:2007 for the involute; Newton's impact law.

struct GearsOnArm {
  long double arm_mass, arm_inertia, arm_centre;  ///< kg, kg m² about the centre of mass, m from the pivot
  std::array<long double, 2> mass, inertia, base, place;  ///< of the gears; base radii, p₁ and p₂
  long double backlash, restitution, gravity;

  long double inertia_about_pivot() const {
    return arm_inertia + arm_mass * arm_centre * arm_centre + mass[0] * place[0] * place[0] +
           mass[1] * place[1] * place[1];
  }
};

using GearsOnArmState = std::array<long double, 6>;  ///< θ, φ₁, φ₂, and their rates

struct FlankImpact {
  int flank;  ///< σ
  long double t, approach, impulse;
};

inline GearsOnArmState gears_on_arm_flight(const GearsOnArm& m, const GearsOnArmState& y, long double h) {
  static const CooperVerner<long double> method;
  const long double weight = m.gravity *
                             (m.arm_mass * m.arm_centre + m.mass[0] * m.place[0] + m.mass[1] * m.place[1]) /
                             m.inertia_about_pivot();
  const auto rates = [&](long double, const GearsOnArmState& s) {
    return GearsOnArmState{s[3], s[4], s[5], -weight * std::cos(s[0]), 0, 0};
  };
  return method.step(rates, 0.0L, y, h);
}

/// The first `count` impacts from the state y at t = 0.
inline std::vector<FlankImpact> gears_on_arm_impacts(const GearsOnArm& m, GearsOnArmState y, int count) {
  const long double S = m.base[0] + m.base[1], J = m.inertia_about_pivot();
  const auto middle = [&](const GearsOnArmState& s) {
    return S * s[0] - m.base[0] * s[1] - m.base[1] * s[2];
  };
  const long double centred = middle(y), step = 1e-5L;
  const long double effective =
      1 / (S * S / J + m.base[0] * m.base[0] / m.inertia[0] + m.base[1] * m.base[1] / m.inertia[1]);
  std::vector<FlankImpact> list;
  long double t = 0;
  while (static_cast<int>(list.size()) < count) {
    // A closing flank; the step after an impact starts at a gap of rounding that opens.
    const auto closed = [&](const GearsOnArmState& s) {
      const long double x = middle(s) - centred, u = S * s[3] - m.base[0] * s[4] - m.base[1] * s[5];
      if (x >= m.backlash / 2 && u > 0) return -1;
      if (x <= -m.backlash / 2 && u < 0) return 1;
      return 0;
    };
    auto next = gears_on_arm_flight(m, y, step);
    if (closed(next) == 0) {
      y = next, t += step;
      continue;
    }
    long double low = 0, high = step;
    bisect(low, high, 200, [&](long double mid) { return !closed(gears_on_arm_flight(m, y, mid)); });
    y = gears_on_arm_flight(m, y, high), t += high;
    const int flank = closed(y);
    const long double approach = std::abs(S * y[3] - m.base[0] * y[4] - m.base[1] * y[5]);
    const long double P = (1 + m.restitution) * effective * approach;
    y[3] += flank * P * S / J;
    y[4] -= flank * P * m.base[0] / m.inertia[0];
    y[5] -= flank * P * m.base[1] / m.inertia[1];
    list.push_back({flank, t, approach, P});
  }
  return list;
}

}  // namespace freeplay::reference
