// ImpactIsland: contacts coupled by D in impact at one instant. It holds the input and output of an
// impact law (impact.hpp): D, the rates before, and the resulting works and summary.
#pragma once

#include <Eigen/Core>

#include <vector>

#include "formulations/contact/contact_problem.hpp"
#include "mechanism/options.hpp"

namespace freeplay {

/// Impact of a single contact, integrated along its normal impulse (Routh, Dynamics of a System of
/// Rigid Bodies, 1905). By Poisson's law it ends when the impulse of expansion is e times the
/// impulse of compression (Wang and Mason, J. Appl. Mech. 59 (1992) 635); by the energetic law, when
/// the work of expansion is e² times the work of compression (Stronge).
struct RouthImpact {
  double impulse_n = 0, impulse_t = 0;  ///< N s
  /// J, of the impulses on the rates during the impact; negative: lost
  double normal_work = 0, tangential_work = 0;
  /// False if no impulse ends the approach: the only freedom of the contact cannot change its
  /// approach rate.
  bool ended = true;
};

/// D and the rates before the impact, of one contact; D_TT = 0 without friction. Both rows of D may
/// depend on one freedom (a lever on a stop): sliding then stops at the very end of compression.
RouthImpact routh_impact(ImpactLaw law, double Dnn, double Dnt, double Dtt, double u_n, double u_t, double mu,
                         double e);

/// A contact in impact: its rows of D and u, its coefficients, and its impulses.
struct ImpactContact {
  /// tangent −1: frictionless; normal −1: friction of a joint, with Newton's law only
  int normal = -1, tangent = -1;
  double restitution = 0, tangential_restitution = 0, friction = 0;
  double stiffness_ratio = 1;           ///< κ, read by the compliant law
  double impulse_n = 0, impulse_t = 0;  ///< N s
  /// N s, bound of friction in addition to μ times the normal impulse
  double bound = 0;
  /// J, work of a phase's impulses on the rates during the phase; negative: lost
  double work_n = 0, work_t = 0;
};

struct ImpactIsland {
  ImpactIsland(LcpSolver solver, double tolerance) : problem(solver, tolerance) {
    problem.least = Least::always;
  }

  /// The unknowns of the contacts, without targets or impulses.
  void pose(const std::vector<ImpactContact>& contacts);
  /// Solves the present problem and adds its result to `solution`.
  bool solve();
  /// Adds the change of the rates by an impulse.
  void act(Eigen::VectorXd& rates, const ImpactContact& by) const;
  /// Adds the works of impulses that grow in proportion, from `before` to `after`.
  void add_works_at_once(const std::vector<ImpactContact>& contacts);
  double greatest_rate() const { return before.cwiseAbs().maxCoeff(); }

  ContactProblem problem;         ///< D and rows of the island
  Eigen::VectorXd before, after;  ///< rates; `after` is set by laws that give the impulses at once
  ContactSolution solution;       ///< summary of all problems so far
  /// J, of the impulses on the contacts' rates; negative: lost
  double normal_work = 0, tangential_work = 0;
  bool wedged = false;  ///< no ratios were found that give the works of the contacts
};

/// Impact of a single contact in its island, integrated along its normal impulse (RouthImpact).
bool routh_impact(ImpactLaw law, ImpactIsland& island, ImpactContact& c);

}  // namespace freeplay
