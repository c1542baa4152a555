// Reachable regions of points: at some positions, the farthest place of a point in directions all around,
//
//     max over u ∈ U of cos φ x(u) + sin φ y(u),     φ = 0, 5°, …, 355°,
//
// with the search and the bound of the range of an output (play_extremes.hpp). The places are corners of a polygon
// inside the convex hull of the region, and the bounds are sides of a polygon about it.
#pragma once

#include "analysis/play/play.hpp"
#include "analysis/play/play_extremes.hpp"

namespace freeplay {

/// Fills Play::regions: for each point both of whose coordinates are quantities, at most four positions at equal
/// distances, one of which has the widest range. Throws Interrupted.
void add_regions(LooseMechanism& mechanism, PlayExtremes& extremes, Play& play, const StopToken& stop);

}  // namespace freeplay
