// The fixed frame, whose only facts are named points.
#pragma once

#include <string_view>
#include <vector>

#include "mechanism/body.hpp"

namespace freeplay {

/// The reader replaces each name by its coordinates, so a Mechanism stores coordinates only.
struct Ground {
  static constexpr std::string_view what = "[ground]";
  std::vector<NamedPoint> points = {};  ///< m, world coordinates

  static void keys(auto& k, auto& g) {
    k.points(
        {"points", "m", "named points of the ground for `at`, { A = [x, y], ... }, in world coordinates"}, "",
        g.points);
  }
};

}  // namespace freeplay
