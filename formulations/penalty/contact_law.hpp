// Point-contact laws with hysteresis damping,
//
//     F = K δⁿ (1 + χ δ̇/v₀),     clamped at zero,     n = 3/2,
//
// which differ in the damping factor χ alone. For a free impact the restitution ê that such a law delivers
// obeys
//
//     χ (1 + ê) = ln[(1 + χ)/(1 − χ ê)]
//
// for any K, n and mass: divide m δ̇ dδ̇ = −F dδ by the bracket and integrate over the loop, where ∮ K δⁿ dδ =
// 0. Solved for χ at a given ê it is the exact law. Sources of χ: Lankarani and Nikravesh, J. Mech. Des. 112
// (1990) 369: ¾(1 − e²); Flores, Machado, Silva, Martins, Multibody Syst. Dyn. 25 (2011) 357: 8(1 − e)/(5e).
#pragma once

#include <string>

#include "model/scene.hpp"

namespace freeplay {

/// One contact's law, ready to evaluate.
struct ContactForce {
  double stiffness = 0;  ///< K, N/m^1.5
  double chi = 0;        ///< χ, ≥ 0
  static constexpr double exponent = 1.5;

  double elastic_force(double delta) const { return stiffness * delta * __builtin_sqrt(delta); }
  double elastic_energy(double delta) const {
    return stiffness * delta * delta * __builtin_sqrt(delta) / (exponent + 1);
  }
};

const char* name_of(ContactLaw law);

/// χ of a law at the restitution asked for. Throws SceneError where the law has none.
double damping_factor(ContactLaw law, double restitution);
/// ê from χ by the equation above, by a bracketed root search (Boost TOMS 748).
double delivered_restitution(double chi);
/// χ from ê, 0 < ê ≤ 1.
double exact_damping_factor(double restitution);

/// Hertz's K = (4/3) E* √(R_i R_j/(R_i − R_j)) of a journal inside a bearing, E* = E/(2(1 − ν²)) for like
/// materials.
double hertz_stiffness(double young, double poisson, double radius_bearing, double radius_journal);

/// Duration of the undamped impact of a mass m at speed v: 2.9432 δ_max/v, δ_max = (5 m v²/(4K))^(2/5).
double hertz_duration(double stiffness, double mass, double speed);

}  // namespace freeplay
