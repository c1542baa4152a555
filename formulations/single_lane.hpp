// A run in a lane of its own: ordinary fixed steps that no observer sees are made by the functions of
// steps in lanes (time_stepping/lane_group.hpp) with one lane, which do a whole step at once. The result
// is that of Formulation::run(), bit for bit.
#pragma once

#include <functional>
#include <vector>

#include "dynamics/lane_functions.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

struct SingleLane {
  LaneFunctions functions;        ///< lanes = 1, or 0: there are none
  std::vector<double> constants;  ///< of its traced functions (TracedLanes)
};

/// Runs a formulation to `until` (s). `next_shown`: as for LaneRun. `lane`: asked after each step that
/// is not in the lane, until it returns something; then its functions are used.
Ending run_in_single_lane(Formulation& formulation, double until, Watch& watch,
                          const std::function<double()>& next_shown,
                          const std::function<const SingleLane*()>& lane);

}  // namespace freeplay
