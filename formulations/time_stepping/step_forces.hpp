// StepForces: forces of a step, for observers. A step computes impulses; those of contacts in
// impact, with the reactions of the joints to them, are separated from the rest. The forces of a
// step are the remaining impulses divided by its length.
#pragma once

#include <vector>

#include "formulations/time_stepping/step_problem.hpp"

namespace freeplay {

class StepForces {
 public:
  void watch(const System& system, bool on);
  bool watching() const { return watching_; }
  /// Collects the impulses of the step, at its middle.
  void collect(StepData& step, const ContactSet& contacts, const StepProblem& problem,
               ImpulseResponses& responses, const FilmStep& films);
  void at(double t_old, double t, Forces& out) const {
    out.clear();
    if (t > t_old) out.add(1 / (t - t_old), smooth_);
  }

  const Forces& nothing() const { return nothing_; }
  /// Impulses without the impacts (smooth) and of the impacts (within).
  Forces& smooth() { return smooth_; }
  const Forces& smooth() const { return smooth_; }
  const Forces& within() const { return within_; }

 private:
  bool watching_ = false;
  Forces nothing_, smooth_, within_;
  std::vector<double> struck_lambda_, smooth_lambda_;
};

}  // namespace freeplay
