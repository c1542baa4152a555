// Rigid connection of two bodies at a point with a fixed relative angle: three rows.
#pragma once

#include <array>
#include <string>

#include "mechanism/body.hpp"

namespace freeplay {

/// Rigid connection of two bodies.
struct RigidJoint {
  static constexpr std::string_view type = "rigid";
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< m, one point of each body, in its frame
  /// rad, θ of the second body minus θ of the first
  double angle = 0;

  std::string_view what() const { return "a rigid joint"; }

  static void keys(auto& k, auto& j) {
    k.between("two bodies, or \"ground\" and a body", j.between);
    k.ends("the joint's point in each body's frame, from its centre of mass; ground: world", j.at);
    k.take({"angle", "rad", "angle of the second body less that of the first"}, j.angle);
  }
};

}  // namespace freeplay
