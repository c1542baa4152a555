// Error of reduced beams in the natural frequencies of a mechanism: those with reduced beams beside those with the full
// beams, about the same state with closed contacts rigid (dynamics/assembly/modes.hpp).
#pragma once

#include <vector>

#include "mechanism/mechanism.hpp"
#include "values/state.hpp"

namespace freeplay {

struct ReducedFrequency {
  double reduced = 0;  ///< Hz
  double full = 0;     ///< Hz, of the mode whose shape x has the greatest (xᵀ M y)²/(xᵀ M x yᵀ M y)
  double error() const { return reduced / full - 1; }
};

/// The oscillations of the mechanism with reduced beams, by frequency.
std::vector<ReducedFrequency> reduced_frequencies(const Mechanism& mechanism, const State& at);

}  // namespace freeplay
