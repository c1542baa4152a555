// Positions of the joints of a mechanism in a pose q of its bodies.
#pragma once

#include <cmath>
#include <variant>
#include <vector>

#include "dynamics/planar.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {

/// A point of a body in the world (m); for the ground, the point itself.
inline Vec2 place_of(const std::vector<double>& q, int body, const Vec2& at) {
  if (body == ground) return at;
  const double angle = planar::angle(q.data(), body), c = std::cos(angle), s = std::sin(angle);
  return planar::position(q.data(), body) + Vec2{c * at.x() - s * at.y(), s * at.x() + c * at.y()};
}

/// A joint's point in the frame of its first or second body; the centre of mass for kinds without
/// points.
inline Vec2 end_of(const Joint& joint, int end) {
  return std::visit(
      [&](const auto& j) {
        if constexpr (requires { j.at[end]; })
          return j.at[end];
        else
          return Vec2{0, 0};
      },
      joint);
}

/// A joint's point of its first or second body, in the world.
inline Vec2 end_place(const Joint& joint, int end, const std::vector<double>& q) {
  return place_of(q, bodies_of(joint)[end], end_of(joint, end));
}

/// The position of a joint: its point of the second body, which moves with a slider; of the first
/// body if the second is the ground.
inline Vec2 joint_place(const Joint& joint, const std::vector<double>& q) {
  return end_place(joint, bodies_of(joint)[1] == ground ? 0 : 1, q);
}

}  // namespace freeplay
