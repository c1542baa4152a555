// Reactions that mechanics does not determine.
#pragma once

#include <vector>

#include "values/state.hpp"

namespace freeplay {

class System;

/// Indices into System::force_elements() of ideal joints and drives whose reactions are not unique
/// at a state: some combination z of their rows has Gᵀz = 0, so any multiple of it may be added to
/// the multipliers.
std::vector<int> undetermined_elements(const System& system, const State& state);

/// Throws ModelError if such a reaction bounds a friction.
void refuse_undetermined_friction(const System& system, const State& state);

}  // namespace freeplay
