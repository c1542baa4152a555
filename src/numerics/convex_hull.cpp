#include "numerics/convex_hull.hpp"

#include <algorithm>

namespace freeplay {

std::vector<std::size_t> convex_hull(const std::vector<Vec2>& points) {
  const auto n = points.size();
  const auto first =
      static_cast<std::size_t>(std::ranges::max_element(points, {}, &Vec2::squared_norm) - points.begin());
  std::vector<std::size_t> list;
  for (std::size_t i = 0; i <= n; ++i) {
    const auto next = (first + i) % n;
    while (list.size() > 1) {
      const Vec2 &a = points[list[list.size() - 2]], &b = points[list.back()];
      if (cross(b - a, points[next] - b) > 0) break;
      list.pop_back();
    }
    if (i < n) list.push_back(next);
  }
  return list;
}

}  // namespace freeplay
