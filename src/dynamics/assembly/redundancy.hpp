// Which reactions mechanics does not determine.
#pragma once

#include <vector>

#include "values/state.hpp"

namespace freeplay {

class System;

/// Indices into System::force_elements() of ideal joints and drives whose reactions are not unique at a state: some
/// combination z of rows has Gᵀz = 0 and acts on them, so that any multiple of it may be added to the multipliers.
std::vector<int> undetermined_elements(const System& system, const State& state);

/// Throws ModelError where friction is bounded by such a reaction.
void refuse_undetermined_friction(const System& system, const State& state);

}  // namespace freeplay
