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
#include <optional>
#include <string>
#include <vector>

#include "formulations/contact/contact_problem.hpp"

namespace freeplay {

/// A contact that takes part: rows of D and u, its coefficients, and its impulses.
struct ImpactContact {
  int normal = -1,
      tangent = -1;  ///< tangent −1: frictionless; normal −1: friction of a joint, Newton's law alone
  double restitution = 0, tangential_restitution = 0, friction = 0;
  double impulse_n = 0, impulse_t = 0;  ///< N s
  double bound = 0;                     ///< N s, of friction beside μ times the normal impulse
  double work_n = 0, work_t = 0;  ///< J, of a phase's impulses on the rates as they were; negative: lost
};

/// An impact starts from no guess and fills what it reads: nothing passes from one to the next but the modes left to
/// try.
class ImpactProblem {
 public:
  ImpactProblem(ImpactLaw law, LcpSolver solver, double tolerance) : law_(law), problem_(solver, tolerance) {
    problem_.least = ContactProblem::Least::always;
  }

  /// Solves for the impulses; `u` are the rates before. An empty text, or why there are none.
  std::string solve(const Eigen::MatrixXd& D, const Eigen::VectorXd& u, int rows,
                    std::vector<ImpactContact>& contacts);
  /// Of the last solve: work of the impulses on the contacts' rates (J, negative: lost), normal and
  /// tangential.
  double normal_work() const { return normal_work_; }
  double tangential_work() const { return tangential_work_; }
  const ContactSolution& solution() const { return solution_; }
  /// The last solve took e = 0, for no impulses were found that keep the law: contacts that share a body between
  /// walls may be asked for rates that cannot be had together, as a disc in a channel of its own width.
  bool inelastic() const { return inelastic_; }
  /// The last solve by the energetic law took Poisson's ratios, for none were found that give the contacts' works:
  /// friction between several may let there be none.
  bool wedged() const { return wedged_; }
  long& modes_left() { return problem_.modes_left; }

 private:
  std::string solve_island(std::vector<ImpactContact>& contacts);
  bool by_law(std::vector<ImpactContact>& contacts);
  bool newton(std::vector<ImpactContact>& contacts);
  enum class Phase { compression, expansion };
  bool follow(Phase phase, const std::vector<double>& ratio, Eigen::VectorXd& rates,
              std::vector<ImpactContact>& done);
  bool piece(Phase phase, const std::vector<double>& ratio, double from, double to,
             const Eigen::VectorXd& rates);
  double ahead(Phase phase, const ImpactContact& c, double at, const Eigen::VectorXd& rates) const;
  bool goes_on(Phase phase, double from, const Eigen::VectorXd& rates) const;
  double first_change(Phase phase, double from, const Eigen::VectorXd& rates, double early,
                      double late) const;
  std::optional<double> piece_until_change(Phase phase, const std::vector<double>& ratio, double from,
                                           const Eigen::VectorXd& rates);
  bool compress(const std::vector<ImpactContact>& contacts);
  bool expand(std::vector<ImpactContact>& contacts, const std::vector<double>& ratio);
  bool routh(ImpactContact& contact);
  bool energetic(std::vector<ImpactContact>& contacts);
  void prepare(const std::vector<ImpactContact>& contacts);
  void act(Eigen::VectorXd& rates, const ImpactContact& by) const;
  void book_at_once(const std::vector<ImpactContact>& contacts);
  bool solve_problem();

  ImpactLaw law_;
  ContactProblem problem_;    // of the present island
  ContactSolution solution_;  // of all islands and phases
  Eigen::VectorXd before_, after_compression_, after_, trial_, early_, late_;
  std::vector<ImpactContact> compression_, expansion_, piece_;
  double normal_work_ = 0, tangential_work_ = 0;
  bool inelastic_ = false, wedged_ = false;
};

}  // namespace freeplay
