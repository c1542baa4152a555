// A run in a lane of its own: ordinary fixed steps (lane_functions.hpp) that no observer sees are made by the
// functions of steps in lanes (lane_group.hpp) with one lane, which make a whole step at once. The result is
// bitwise identical to that of Formulation::run().
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "formulations/time_stepping/lane_functions.hpp"
#include "numerics/saddle_point.hpp"
#include "simulation/formulation.hpp"
#include "values/state.hpp"

namespace freeplay {

class Step;
class System;
struct SystemFunctions;

/// Runs a formulation to `until` (s). `next_shown` and `follow`: as for LaneRun. The lane is used once its
/// functions are attached to the formulation's System, which may be during the run.
Ending run_in_single_lane(Formulation& formulation, double until, Watch& watch,
                          const std::function<double()>& next_shown,
                          const std::function<void(const Step&)>& follow);

// Runs of fixed time steps in lanes: several formulations of mechanisms of one structure step together
// (time_stepping/lane_group.hpp) wherever their steps are ordinary and no observer sees them; all other
// steps are those of their own run, one after the other. A run that ends leaves its lane to the next
// one. The results are bitwise identical to those of separate runs.

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

// Compares steps in lanes with those of each system alone, before a run uses them (lane_check.cpp).

/// Number of quantities in which fixed steps by `functions`, alone and in a lane, and without them differ,
/// from a state and from others near it, at most `states`; a sign of zero is no difference. Detaches all
/// functions.
long differing_steps(System& system, const SystemFunctions& functions, const State& near, RowFacts facts,
                     int states = 4);

/// A system in a lane; nothing is owned.
struct LaneCheck {
  const System* system;
  const State* near;                     ///< a state
  const std::vector<double>* constants;  ///< of its traced functions
};
/// The same for steps in lanes against those of each system alone.
long differing_lanes(const LaneFunctions& functions, const std::vector<LaneCheck>& lanes, RowFacts facts,
                     int states = 4);

}  // namespace freeplay
