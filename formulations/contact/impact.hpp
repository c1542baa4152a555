// Impact laws: impulses of contacts that are struck at one instant, from the rates just before and the
// Delassus matrix D = WᵀAW. With Coulomb friction for impulses throughout.
//
//   newton     u_N⁺ ≥ −e u_N⁻ ⊥ P_N ≥ 0,   −P_T ∈ μ P_N Sgn(u_T⁺ + e_T u_T⁻)
//              With one e for all contacts and no friction it never raises the energy; with friction it can
//              (Kane and Levinson, Dynamics: Theory and Applications, 1985). A contact that would open faster
//              than that bears no impulse.
//   poisson    P_N = e P_C + extra,   extra ≥ 0 ⊥ u_N⁺ ≥ 0
//              in expansion; a compression phase with e = 0 gives P_C (Glocker and Pfeiffer, Nonlinear
//              Dynamics 7 (1995) 471). Friction follows the sliding along each phase, not its end alone.
//   energetic  W_expansion = −e² W_compression,   W the work of the normal impulse in a phase
//              (Stronge, Proc. R. Soc. Lond. A 431 (1990) 169). Several contacts that D couples take poisson's
//              phases, with each contact's share of expansion iterated until its own works stand in that ratio
//              (impact_energetic.cpp); where none are found, Poisson's.
//
// By these two one contact alone is integrated along its normal impulse (Routh), with slip, stick and reversal, several along
// their phases (impact_phases.cpp). Works are those along the impact, so that friction's is never a gain.
//
// Contacts that D does not couple are impacts of their own. Where the laws admit several impulses the least are taken
// (contact_least.cpp), in each phase.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "formulations/contact/impact_laws.hpp"

namespace freeplay {

/// An impact starts from no guess and fills what it reads: nothing passes from one to the next but the modes left to
/// try.
class ImpactProblem {
 public:
  ImpactProblem(ImpactLaw law, LcpSolver solver, double tolerance) : law_(law), island_(solver, tolerance) {}

  /// Solves for the impulses; `u` are the rates before. An empty text, or why there are none.
  std::string solve(const Eigen::MatrixXd& D, const Eigen::VectorXd& u, int rows,
                    std::vector<ImpactContact>& contacts);
  /// Of the last solve: work of the impulses on the contacts' rates (J, negative: lost), normal and
  /// tangential.
  double normal_work() const { return island_.normal_work; }
  double tangential_work() const { return island_.tangential_work; }
  const ContactSolution& solution() const { return island_.solution; }
  /// The last solve took e = 0, for no impulses were found that keep the law: contacts that share a body between
  /// walls may be asked for rates that cannot be had together, as a disc in a channel of its own width.
  bool inelastic() const { return inelastic_; }
  /// The last solve by the energetic law took Poisson's ratios, for none were found that give the contacts' works:
  /// friction between several may let there be none.
  bool wedged() const { return island_.wedged; }
  long& modes_left() { return island_.problem.modes_left; }

 private:
  std::string solve_island(std::vector<ImpactContact>& contacts);

  ImpactLaw law_;
  ImpactIsland island_;  // the present one, with the sums of all
  ImpactPhases phases_;
  bool inelastic_ = false;
};

}  // namespace freeplay
