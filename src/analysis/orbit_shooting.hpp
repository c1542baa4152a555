// Multiple shooting: Newton's method on the states at the beginnings of all periods of a motion at once,
//
//     P₁(x_k) − x_{k+1} = 0,   k = 1 … N,   x_{N+1} = x₁,
//
// with the return map P₁ of one period. An error of a state grows over one period only, so that unstable
// motions of several periods are found from starts at which the map of all periods is far from linear
// (docs/theory/orbits.md).
#pragma once

#include <optional>

#include "analysis/return_map.hpp"

namespace freeplay {

struct Shooting {
  SectionState first;  ///< at the beginning of the first period
  int iterations = 0;
};

/// Searches a motion of `periods` periods (s) near the one that begins at `start`; nothing if the search ends
/// far from one. For motions with a drive, without a shift.
std::optional<Shooting> shoot_periods(const Scene& scene, const System& system, double period, int periods,
                                      const SectionState& start, StopToken stop);

}  // namespace freeplay
