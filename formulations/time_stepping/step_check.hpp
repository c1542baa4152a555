// Compares steps by compiled functions with the general path, before a run uses them.
#pragma once

#include "numerics/saddle_point.hpp"
#include "values/state.hpp"

namespace freeplay {

class System;
struct SystemFunctions;

/// Number of quantities in which fixed steps by `functions` and without them differ, from a state
/// and from others near it; a sign of zero is no difference. Detaches all functions.
long differing_steps(System& system, const SystemFunctions& functions, const State& near, RowFacts facts);

}  // namespace freeplay
