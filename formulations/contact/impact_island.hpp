// Contacts that D couples, in impact at one instant: what impact laws read and leave (impact_laws.hpp).
#pragma once

#include <Eigen/Core>
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

struct ImpactIsland {
  ImpactIsland(LcpSolver solver, double tolerance) : problem(solver, tolerance) {
    problem.least = Least::always;
  }

  /// The unknowns of the contacts, without targets or impulses.
  void pose(const std::vector<ImpactContact>& contacts);
  /// Solves the posed problem and adds what that took to `solution`.
  bool solve();
  /// Adds what an impulse does to the rates.
  void act(Eigen::VectorXd& rates, const ImpactContact& by) const;
  /// Adds the works of impulses that grow together, from `before` to `after`.
  void add_works_at_once(const std::vector<ImpactContact>& contacts);
  double greatest_rate() const { return before.cwiseAbs().maxCoeff(); }

  ContactProblem problem;                       ///< D and rows of the island
  Eigen::VectorXd before, after;                ///< rates; `after` where the law gives the impulses at once
  ContactSolution solution;                     ///< of all problems so far
  double normal_work = 0, tangential_work = 0;  ///< J, of the impulses on the contacts' rates; negative: lost
  bool wedged = false;                          ///< no ratios were found that give the contacts' works
};

/// A contact alone in its island, along its normal impulse (routh.hpp).
bool routh_impact(ImpactLaw law, ImpactIsland& island, ImpactContact& c);

}  // namespace freeplay
