// A massless rod between two bodies, pinned at both ends. It fixes the distance of two points
// (rows/distance.hpp): one row.
#pragma once

#include <array>
#include <string>

#include "mechanism/body.hpp"

namespace freeplay {

/// Massless rod between two points.
struct RodJoint {
  static constexpr std::string_view type = "rod";
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< m, one point of each body, in its frame
  double length = 0;                               ///< m, > 0

  std::string_view what() const { return "a rod"; }

  static void keys(auto& k, auto& j) {
    k.between("two bodies, or \"ground\" and a body", j.between);
    k.ends("its two ends", j.at);
    k.need({"length", "m", "distance of its ends"}, j.length, positive);
  }
};

}  // namespace freeplay
