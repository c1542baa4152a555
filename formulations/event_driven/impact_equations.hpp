// Impulses of an impact at fixed positions: the rows of the contacts that touch and of the joints whose reactions bound their
// friction, their rates before, and an impact law (contact/impact.hpp). Friction of joints has bounds that are iterated until
// they agree with the reaction impulses (contact/bound_iteration.hpp).
#pragma once

#include <string>
#include <vector>

#include "formulations/contact/bound_iteration.hpp"
#include "formulations/contact/impact.hpp"
#include "formulations/event_driven/mode_equations.hpp"

namespace freeplay {

class ImpactEquations {
 public:
  using Vector = std::vector<double>;

  ImpactEquations(const NonsmoothOptions& options, const ModeEquations& d);

  struct Impact {
    const std::vector<int>& contacts;   ///< whose gaps are closed
    const std::vector<int>& inelastic;  ///< of them, those that take e = 0 and e_T = 0
    /// Without collision: the contacts press at rates that only just approach, and friction takes what impulses it needs.
    bool without_collision = false;
  };
  /// Impulses at the state x, in each contact. An empty text, or why there are none.
  std::string solve(ModeEquations& d, const Vector& x, double t, const Impact& impact);
  /// Adds the impulses to the velocities of x and to its sums of impulses, and the work of drives to `drive` (J).
  void apply(ModeEquations& d, Vector& x, const std::vector<int>& contacts, double& drive);
  /// Impulses of the last impact at x, into a cleared table.
  void report(ModeEquations& d, const Vector& x, const std::vector<int>& contacts, Forces& out) const;

  /// Of the last impact: work of normal and of tangential impulses (J), whether it took e = 0 for want of impulses that keep
  /// the law, and the rate of approach given to one without collision (m/s).
  double normal_work() const { return impact_.normal_work(); }
  double tangential_work() const { return impact_.tangential_work(); }
  bool inelastic() const { return impact_.inelastic(); }
  double pressing_rate() const { return pressing_rate_; }
  /// The rate (m/s) that its i-th contact would have from its own normal impulse alone.
  double own_rate(const ModeEquations& d, std::size_t i) const {
    return struck_[i].impulse_n * d.rows.K(struck_[i].normal, struck_[i].normal);
  }
  long& modes_left() { return impact_.modes_left(); }

 private:
  void pose(ModeEquations& d, const Vector& x, const Impact& impact);
  void press(ModeEquations& d);
  std::string solve_bounded(ModeEquations& d, const double* v, std::size_t contacts);
  std::vector<double> pose_driven(ModeEquations& d, std::size_t contacts);
  double mean_rate(const ModeEquations& d, int own, bool driven, const double* v) const;

  ImpactProblem impact_;
  std::vector<ImpactContact> struck_;  // contacts, then joints with friction from their reactions
  std::vector<double> lambda_;         // impulses of the constraint rows
  BoundIteration bounds_;
  Eigen::VectorXd image_;
  double pressing_rate_ = 0;
};

}  // namespace freeplay
