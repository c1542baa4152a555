// StepKernel: the compiled beginning and end of a step (lane_functions.hpp) for one MoreauStepper. They take
// the place of the general path for fixed steps of mechanisms that have them, with bitwise identical results.
// Each call returns false if there are none, or if a comparison has another result than at the sample;
// the general path then does that part of the step.
#pragma once

#include <vector>

#include "formulations/time_stepping/lane_functions.hpp"

namespace freeplay {

class ContactSet;
struct StepData;

class StepKernel {
 public:
  /// Evaluates the middle of the step, factorises there, and computes v and λ without contacts.
  bool middle(StepData& step, ContactSet& contacts);
  /// Computes q, corrected onto Φ = 0, all multipliers, mean velocity, gaps and works, from v with all
  /// impulses. q before the correction is in step.dq. Where no gap is negative, constraint residuals are
  /// counted.
  bool end(StepData& step, ContactSet& contacts);

 private:
  bool connect(StepData& step, ContactSet& contacts);
  double*& at(LaneArray array) { return table_[static_cast<std::size_t>(array)]; }

  LaneTable table_{};
  const StepData* step_ = nullptr;  // of which the table has arrays; null: the functions are not usable
  const void *contacts_ = nullptr, *object_ = nullptr;
  std::vector<double> room_;  // of arrays that the step does not have
};

}  // namespace freeplay
