// Impact laws: impulses of all contacts in impact at one instant, from the rates just before the
// impact and the Delassus matrix D = WᵀAW. All laws use Coulomb friction for impulses.
//
//   newton     u_N⁺ ≥ −e u_N⁻ ⊥ P_N ≥ 0,   −P_T ∈ μ P_N Sgn(u_T⁺ + e_T u_T⁻)
//              With one e for all contacts and no friction it never increases the energy; with
//              friction it can (Kane and Levinson, Dynamics: Theory and Applications, 1985).
//              A contact that separates faster than −e u_N⁻ has no impulse.
//   poisson    P_N = e P_C + extra,   extra ≥ 0 ⊥ u_N⁺ ≥ 0
//              in expansion; a compression phase with e = 0 gives P_C (Glocker and Pfeiffer,
//              Nonlinear Dynamics 7 (1995) 471). Friction follows the sliding velocity along each
//              phase, not only at its end.
//   energetic  W_expansion = −e² W_compression,   W the work of the normal impulse in a phase
//              (Stronge, Proc. R. Soc. Lond. A 431 (1990) 169). Several contacts that D couples
//              use Poisson's phases, with each contact's ratio of expansion iterated until its
//              works satisfy this equation (impact.cpp); Poisson's ratios are used if
//              no solution is found.
//
//   compliant  contacts of normal and tangential springs with Coulomb friction in series, followed
//              in time (compliant_impact.cpp; Maw, Barber and Fawcett, 1981)
//
// The poisson and energetic laws integrate a single contact along its normal impulse (Routh), with
// slip, stick and reversal, and several contacts along their phases (impact_phases.cpp). Works are
// computed along the impact, so that friction never gains energy.
//
// Groups of contacts that D does not couple are separate impacts. Where a law admits several
// impulses, the least are taken in each phase (contact_least.cpp).
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

#include "formulations/contact/impact_island.hpp"
#include "formulations/contact/impact_phases.hpp"

namespace freeplay {

// Interface of impact laws: three in impact.cpp, the compliant law in compliant_impact.cpp. A law gets
// an island with D and the rates before the impact, sets the impulses of its contacts and adds their
// works to the island. It returns false if no impulses satisfy it. To add a law: its enumerator and row
// (ImpactLaw) in src/mechanism/options.hpp, its file, its function here and its case below.

using ImpactContacts = std::vector<ImpactContact>;

/// `phases`: work space for laws that integrate an impact through its phases.
bool newton_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);
bool poisson_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);
bool energetic_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);
bool compliant_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);

inline bool impact_by(ImpactLaw law, ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts) {
  switch (law) {
    case ImpactLaw::newton:
      return newton_impact(island, phases, contacts);
    case ImpactLaw::poisson:
      return poisson_impact(island, phases, contacts);
    case ImpactLaw::energetic:
      return energetic_impact(island, phases, contacts);
    case ImpactLaw::compliant:
      return compliant_impact(island, phases, contacts);
  }
  return false;
}

/// Solves impacts one by one. An impact uses no initial guess and fills all data that it reads;
/// only the number of modes left to try passes from one impact to the next.
class ImpactProblem {
 public:
  ImpactProblem(ImpactLaw law, LcpSolver solver, double tolerance) : law_(law), island_(solver, tolerance) {}

  /// Solves for the impulses; `u` are the rates before. Returns an empty text, or the reason of a
  /// failure.
  std::string solve(const Eigen::MatrixXd& D, const Eigen::VectorXd& u, int rows,
                    std::vector<ImpactContact>& contacts);
  /// Normal and tangential work of the last solve's impulses on the rates of the contacts (J;
  /// negative: lost).
  double normal_work() const { return island_.normal_work; }
  double tangential_work() const { return island_.tangential_work; }
  const ContactSolution& solution() const { return island_.solution; }
  /// The last solve used e = 0, because no impulses satisfy the law. Contacts of one body between
  /// several walls can require rates that exclude each other, for example a disc in a channel of
  /// its own width.
  bool inelastic() const { return inelastic_; }
  /// The last solve by the energetic law used Poisson's ratios, because no ratios were found that
  /// give the works of the contacts; with friction between several contacts there may be none.
  bool wedged() const { return island_.wedged; }
  long& modes_left() { return island_.problem.modes_left; }

 private:
  std::string solve_island(std::vector<ImpactContact>& contacts);

  ImpactLaw law_;
  ImpactIsland island_;  // the present island; its sums are over all islands
  ImpactPhases phases_;
  bool inelastic_ = false;
};

}  // namespace freeplay
