// Convex hull of points around the origin.
#pragma once

#include <cstddef>
#include <vector>

#include "values/vec2.hpp"

namespace freeplay {

/// The convex hull of points in counterclockwise order around the origin, as their indices in that order. It
/// begins at the point farthest from the origin, which belongs to the hull.
std::vector<std::size_t> convex_hull(const std::vector<Vec2>& points);

}  // namespace freeplay
