// Static equilibrium, reached by descent from a given position:
//
//     R = f − Gᵀλ + Σ W_N F_N = 0,     Φ = 0,
//     0 ≤ F_N ⊥ g ≥ 0  (rigid contacts)   or   F_N = F_el(−g)  (elastic contacts).
//
// For forces with a potential U this is a minimum of U subject to Φ = 0 and g ≥ 0 (or with the
// energy of elastic contacts); λ and F_N are the multipliers. The steps on the manifold Φ = 0 are
// those of Newton's method with the exact reduced Hessian H = Zᵀ K Z, Z a basis of the null space,
// with the absolute values of its curvatures (s = −(|H| + μ)⁻¹ Zᵀ∇U), in a trust region (Conn,
// Gould and Toint, Trust-Region Methods, 2000, ch. 7). U itself is not evaluated: the increase of a
// step is −∫ f·dq along its chord. New elements therefore need no potential, and no cancellation
// occurs.
//
// Rigid contacts are first made elastic, with increasing stiffness; otherwise a step towards a
// contact that is not yet closed would be cut to nothing. Contacts that carry a force at the end,
// when all forces together would compress them by a thousandth of their clearance, are then held
// closed. Those that would pull are opened, until none is left (active-set method).
//
// An equilibrium is stable if H is positive definite (Lagrange and Dirichlet). Friction is
// neglected: normal forces alone hold the mechanism. Prescribed angles have their initial values.
#pragma once

#include <string>
#include <vector>

#include "dynamics/assembly/statics.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

// Restriction of a symmetric matrix K to the motions that rows C allow. With the weights W of the
// coordinates,
//
//     C Z = 0,    ZᵀWZ = 1,    H = ZᵀKZ.

/// A basis Z of the null space of C, with ZᵀWZ = 1, W = diag(weights).
Eigen::MatrixXd null_space(const Eigen::MatrixXd& C, const Eigen::VectorXd& weights);

/// Eigenvalues of H = ZᵀKZ with their error bounds from rounding and cancellation; `weights` as in
/// null_space().
struct Curvatures {
  Eigen::VectorXd value, doubt;
  Eigen::MatrixXd direction;  ///< eigenvectors as columns, in the coordinates q
};
Curvatures curvatures(const Eigen::MatrixXd& K, const Eigen::MatrixXd& Z, const Eigen::VectorXd& weights);

struct Mechanism;

struct Equilibrium {
  enum class Kind {
    stable,    ///< every small displacement is resisted
    marginal,  ///< some motion has no stiffness
    unstable   ///< some motion grows
  };
  State state;                      ///< at rest, t = 0
  std::vector<double> multipliers;  ///< λ of every row, N or N m
  std::vector<double> normal;       ///< F_N of every contact, N; 0: open
  std::vector<int> pressed;         ///< contacts that carry a force
  Kind kind = Kind::stable;
  int freedoms = 0, runaway = 0,
      indifferent = 0;  ///< numbers of independent motions, and of unstable and indifferent ones
  int steps = 0;
};

/// Finds the equilibrium from q, which satisfies Φ = 0. `elastic`: empty, or one entry for each
/// contact. Throws ModelError with the reason if none is found, and Interrupted if `stop` requests
/// it.
Equilibrium find_equilibrium(const Mechanism& mechanism, const System& system, const std::vector<double>& q,
                             const Compliances& elastic, const StopToken& stop = {});

/// Forces of the elements at an equilibrium (ForceReport::elements); accelerations are zero.
Forces static_forces(const System& system, const Equilibrium& at);

/// "stable", or the numbers of motions that are not.
std::string describe(const Equilibrium& at);

}  // namespace freeplay
