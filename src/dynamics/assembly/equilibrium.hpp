// Static equilibrium: the place, reached by descent from a given one, where nothing moves,
//
//     R = f − Gᵀλ + Σ W_N F_N = 0,     Φ = 0,     0 ≤ F_N ⊥ g ≥ 0  (rigid contacts)   or   F_N = F_el(−g)  (elastic ones).
//
// For forces that have a potential U this is its least value over Φ = 0 and g ≥ 0 (or with the contacts' energy), and λ, F_N
// are the multipliers. Steps on the manifold Φ = 0 by Newton's method with the exact reduced Hessian H = Zᵀ K Z, Z a basis of
// the null space, its negative curvatures turned (s = −(|H| + μ)⁻¹ Zᵀ∇U), within a trust region (Conn, Gould and Toint,
// Trust-Region Methods, 2000, ch. 7). U itself is never asked for: a step climbs by −∫ f·dq along its chord, which new
// elements need no potential for and which loses nothing to cancellation.
// Rigid contacts yield first, less and less: a step that meets a wall which is not there yet would else be cut to nothing.
// Those that press in the end, where all forces together push them in by a thousandth of their clearance, are then held
// closed, those that would pull let go, until none does (an active set).
//
// Stable: H is positive definite (Lagrange and Dirichlet). Friction is left out: the place is one that normal forces alone
// hold. Prescribed angles stand at their initial values.
#pragma once

#include <string>
#include <vector>

#include "dynamics/assembly/curvatures.hpp"
#include "dynamics/assembly/statics.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Mechanism;

struct Equilibrium {
  enum class Kind {
    stable,    ///< any small push is answered
    marginal,  ///< some motion meets no stiffness
    unstable   ///< some motion runs away
  };
  State state;                      ///< at rest, t = 0
  std::vector<double> multipliers;  ///< λ of every row, N or N m
  std::vector<double> normal;       ///< F_N of every contact, N; 0: open
  std::vector<int> pressed;         ///< contacts that bear a force
  Kind kind = Kind::stable;
  int freedoms = 0, runaway = 0,
      indifferent = 0;  ///< how many motions are left, and which of them are not stable
  int steps = 0;
};

/// From q, which satisfies Φ = 0. `elastic`: empty, or one a contact. Throws ModelError where there is none to be found,
/// with the reason, and Interrupted when `stop` asks.
Equilibrium find_equilibrium(const Mechanism& mechanism, const System& system, const std::vector<double>& q,
                             const Compliances& elastic, const StopToken& stop = {});

/// Elements at equilibrium (System::force_elements()); accelerations are zero.
Forces static_forces(const System& system, const Equilibrium& at);

/// "stable", or which motions are not.
std::string describe(const Equilibrium& at);

}  // namespace freeplay
