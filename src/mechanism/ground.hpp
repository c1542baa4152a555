// The fixed frame: what it has are names of places.
#pragma once

#include <string_view>
#include <vector>

#include "mechanism/body.hpp"

namespace freeplay {

/// Names stand where they are read for the coordinates that they name: a mechanism holds these alone.
struct Ground {
  static constexpr std::string_view what = "[ground]";
  std::vector<NamedPoint> points = {};  ///< m, world coordinates

  static void keys(auto& k, auto& g) {
    k.points(
        {"points", "m",
         "points by name, { A = [x, y], ... }, in world coordinates, that `at` may name where the ground's point "
         "stands"},
        "", g.points);
  }
};

}  // namespace freeplay
