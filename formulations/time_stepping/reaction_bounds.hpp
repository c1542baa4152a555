// Friction in joints that their own reactions bound (docs/development/decisions/019): −P_T ∈ μ S(Λ) Sgn(u_T⁺) with Λ the impulses of the
// step, those of impacts among them (dynamics/reaction_bound.hpp). Bounds and impulses are iterated until they agree
// (contact/bound_iteration.hpp); μ is that of the mean of the sliding speeds at the step's ends. Where the reactions grow faster than
// the friction that they bound, other motions are looked for, and one that is not unique is a failure.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "formulations/contact/bound_iteration.hpp"
#include "formulations/contact/contact_problem.hpp"
#include "formulations/contact/coupled_friction.hpp"

namespace freeplay {

class ImpulseResponses;
class StepProblem;
struct StepData;

class ReactionBounds {
 public:
  explicit ReactionBounds(const System& system);
  /// Joints with such friction.
  int size() const { return coupled_.size(); }
  /// Solves the collected problem with bounds that agree with its impulses.
  ContactSolution solve(StepData& step, StepProblem& problem, ImpulseResponses& responses);
  /// No force moves the k-th friction element's row: the joint's motion is prescribed.
  bool driven(int k) const { return !driven_.empty() && driven_[static_cast<std::size_t>(k)] != 0; }

  double slide_scale = 0;  ///< m/s, the fastest that joints with friction have slid

 private:
  ContactSolution settle(const Eigen::VectorXd& first, StepData& step, StepProblem& problem,
                         const ImpulseResponses& responses);
  void find_driven(StepData& step, StepProblem& problem);
  void hold_driven(StepProblem& problem) const;
  void follow(StepData& step, const StepProblem& problem, const ImpulseResponses& responses);
  void look_at_end(StepData& step, const StepProblem& problem, const ImpulseResponses& responses);
  bool laws_hold(double share, const StepProblem& problem) const;

  CoupledFriction coupled_;
  BoundIteration iteration_;
  std::vector<double> q_end_, v_end_,
      taken_back_;                     // what EndRates will do, and where it finds the step's end
  std::vector<double> driven_;         // of each friction element's row: > 0, driven
  Eigen::VectorXd image_, start_;      // bounds that the present impulses give
  std::vector<ContactUnknown> found_;  // one motion, while others are looked for
};

}  // namespace freeplay
