// Teeth, slots and stops in closed form.
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

#include <cmath>
#include <vector>

#include "verification/references/bisection.hpp"

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

}  // namespace freeplay::reference
