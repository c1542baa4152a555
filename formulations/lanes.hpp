// Runs of fixed time steps in lanes: several formulations of mechanisms of one structure step together
// (time_stepping/lane_group.hpp) wherever their steps are ordinary and no observer sees them; all other
// steps are those of their own run, one after the other. A run that ends leaves its lane to the next
// one. The results are those of separate runs, bit for bit.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "dynamics/lane_functions.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

class Step;

/// One run; nothing is owned.
struct LaneRun {
  Formulation* formulation;
  double until;  ///< s
  Watch* watch;
  /// Observers need only steps from the last one before this time (s) on. Asked again after each
  /// step that they have seen.
  std::function<double()> next_shown;
  /// If given, it gets each step that is made in a lane, in the order of time and before later steps
  /// are shown. The step has states, rates and contacts; no energies, multipliers and forces.
  std::function<void(const Step&)> follow;
  const std::vector<double>* constants;  ///< of its traced functions (TracedLanes)
  /// Called at its end with the number of its steps that were made in a lane.
  std::function<void(const Ending&, long in_lanes)> ended;
};

/// Whether a formulation may run in lanes, if its mechanism has the functions: time stepping of fixed steps.
bool fits_lanes(Formulation& formulation);

/// Runs all that `next` returns, each to its end. It is asked whenever a lane is empty, and when it had
/// none, again after each end of a run.
void run_in_lanes(const LaneFunctions& functions, const std::function<std::optional<LaneRun>()>& next);

}  // namespace freeplay
