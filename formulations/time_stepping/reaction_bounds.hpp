// ReactionBounds: joint friction with a bound that depends on the joint's own reaction or on the speed
// (docs/development/decisions/019),
//
//     −P_T ∈ μ S(Λ) Sgn(u_T⁺),
//
// where Λ are the impulses of the step, including those of impacts (dynamics/evaluation.hpp),
// and μ is taken at the mean of the sliding speeds at both ends of the step. Bounds and impulses
// are iterated until they agree (contact/coupled_friction.hpp). If the reactions grow faster than
// the friction that they bound, other motions are sought; a motion that is not unique is a failure.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "formulations/contact/contact_problem.hpp"
#include "formulations/contact/coupled_friction.hpp"

namespace freeplay {

class ImpulseResponses;
class StepProblem;
struct StepData;

class ReactionBounds {
 public:
  explicit ReactionBounds(const System& system);
  /// Number of joints with such friction.
  int size() const { return coupled_.size(); }
  bool reads_reactions() const { return coupled_.reads_reactions(); }
  /// Finds the rows that no force can move, and separates them in a new D.
  void find_driven(StepData& step, StepProblem& problem);
  /// After find_driven(): solves the present problem of `problem` with bounds that agree with its impulses.
  ContactSolution solve(StepData& step, StepProblem& problem, ImpulseResponses& responses);
  /// Whether no force can move the row of the k-th friction element, because the joint's motion is
  /// prescribed.
  bool driven(int k) const { return !driven_.empty() && driven_[static_cast<std::size_t>(k)] != 0; }

  double slide_scale = 0;  ///< m/s, the greatest sliding speed so far of joints with friction

 private:
  ContactSolution settle(const Eigen::VectorXd& first, StepData& step, StepProblem& problem,
                         const ImpulseResponses& responses);
  void hold_driven(StepProblem& problem) const;
  void follow(StepData& step, const StepProblem& problem, const ImpulseResponses& responses);
  void look_at_end(StepData& step, const StepProblem& problem, const ImpulseResponses& responses);
  bool laws_hold(double share, const StepProblem& problem) const;

  CoupledFriction coupled_;
  BoundIteration iteration_;
  // predicted correction by EndRates, and the end of the step where it applies
  std::vector<double> q_end_, v_end_, taken_back_;
  std::vector<double> driven_;         // of each friction element's row: > 0, driven
  Eigen::VectorXd image_, start_;      // bounds from the present impulses; initial bounds
  std::vector<ContactUnknown> found_;  // one motion, while others are sought
};

}  // namespace freeplay
