// ImpactEquations: impulses of an impact at fixed positions. It sets up the rows of the closed
// contacts and of the joints whose friction depends on their reactions, with the rates before the
// impact, and solves them by an impact law (contact/impact.hpp). The bounds of joint friction are
// iterated until they agree with the reaction impulses (contact/coupled_friction.hpp).
#pragma once

#include <string>
#include <vector>

#include "formulations/contact/coupled_friction.hpp"
#include "formulations/contact/impact.hpp"
#include "formulations/event_driven/mode_equations.hpp"

namespace freeplay {

class ImpactEquations {
 public:
  using Vector = std::vector<double>;

  ImpactEquations(const NonsmoothOptions& options, const ModeEquations& d);

  struct Impact {
    const std::vector<int>& contacts;   ///< contacts with closed gaps
    const std::vector<int>& inelastic;  ///< those of them with e = 0 and e_T = 0
    /// Impact without collision: small approach rates are prescribed, and friction receives the
    /// impulses that it needs.
    bool without_collision = false;
  };
  /// Computes the impulses of each contact at the state x. Returns an empty text, or the reason of
  /// a failure.
  std::string solve(ModeEquations& d, const Vector& x, double t, const Impact& impact);
  /// Adds the impulses to the velocities of x and to its sums of impulses, and the work of drives
  /// to `drive` (J).
  void apply(ModeEquations& d, Vector& x, const std::vector<int>& contacts, double& drive);
  /// Reports the impulses of the last impact at x to a cleared table.
  void report(ModeEquations& d, const Vector& x, const std::vector<int>& contacts, Forces& out) const;

  /// Results of the last impact: work of normal and of tangential impulses (J), whether it used
  /// e = 0 because no impulses satisfied the law, and the approach rate prescribed in an impact
  /// without collision (m/s).
  double normal_work() const { return impact_.normal_work(); }
  double tangential_work() const { return impact_.tangential_work(); }
  bool inelastic() const { return impact_.inelastic(); }
  double pressing_rate() const { return pressing_rate_; }
  /// The rate change (m/s) of its i-th contact by its own normal impulse alone.
  double own_rate(const ModeEquations& d, std::size_t i) const {
    return in_impact_[i].impulse_n * d.rows.K(in_impact_[i].normal, in_impact_[i].normal);
  }
  long& modes_left() { return impact_.modes_left(); }

 private:
  void pose(ModeEquations& d, const Vector& x, const Impact& impact);
  void press(ModeEquations& d);
  std::string solve_bounded(ModeEquations& d, const double* v, std::size_t contacts);
  std::vector<double> pose_driven(ModeEquations& d, std::size_t contacts);
  double mean_rate(const ModeEquations& d, int own, bool driven, const double* v) const;

  ImpactProblem impact_;
  // contacts, then joints whose friction depends on their reactions: reacting_
  std::vector<ImpactContact> in_impact_;
  std::vector<int> reacting_;   // indices into ModeEquations::coupled
  std::vector<double> lambda_;  // impulses of the constraint rows
  BoundIteration bounds_;
  Eigen::VectorXd image_;
  double pressing_rate_ = 0;
  std::vector<double> ratio_;  // κ of each contact, of the compliant law
};

}  // namespace freeplay
