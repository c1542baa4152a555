// Compares steps by compiled functions with the general path, before a run uses them.
#pragma once

#include <vector>

#include "numerics/saddle_point.hpp"
#include "values/state.hpp"

namespace freeplay {

class System;
struct LaneFunctions;
struct SystemFunctions;

/// Number of quantities in which fixed steps by `functions` and without them differ, from a state
/// and from others near it, at most `states`; a sign of zero is no difference. Detaches all functions.
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
