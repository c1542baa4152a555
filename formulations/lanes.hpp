// Runs of fixed time steps in lanes: several formulations of mechanisms of one structure step together
// (time_stepping/lane_group.hpp) wherever their steps are ordinary and no observer sees them; all other
// steps are those of their own run, one after the other. The results are those of separate runs, bit
// for bit.
#pragma once

#include <functional>
#include <vector>

#include "dynamics/lane_functions.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

/// One run; nothing is owned.
struct LaneRun {
  Formulation* formulation;
  double until;  ///< s
  Watch* watch;
  /// Observers need only steps from the last one before this time (s) on. Asked again after each
  /// step that they have seen.
  std::function<double()> next_shown;
  const std::vector<double>* constants;  ///< of its traced functions (TracedLanes)
};

/// Whether a formulation may run in lanes: time stepping of fixed steps with compiled functions.
bool fits_lanes(Formulation& formulation);

/// Runs all, each to its end; a run that ends leaves its lane to the next one. `in_lanes` counts the
/// steps that were made together.
std::vector<Ending> run_in_lanes(const LaneFunctions& functions, const std::vector<LaneRun>& runs,
                                 long& in_lanes);

}  // namespace freeplay
