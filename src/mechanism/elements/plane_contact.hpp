// A disc (or a point) of the second body and a straight wall of the first: one contact
// (dynamics/pairs.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "mechanism/body.hpp"

namespace freeplay {

/// Contact of a disc of the second body with a straight wall of the first.
struct PlaneContact {
  static constexpr std::string_view type = "plane";
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< a point of the wall, the disc's centre
  /// Unit vector along the wall, in the first body's frame; free space is on its left.
  Vec2 axis{1, 0};
  double radius = 0;  ///< m, ≥ 0
  /// N/m, > 0, of penalty contacts; empty: that of Hertz's contact
  std::optional<double> stiffness = {};
  int surface = -1;  ///< index into Mechanism::surfaces

  std::string_view what() const { return "a plane contact"; }

  static void keys(auto& k, auto& c) {
    k.between("two bodies, or \"ground\" and a body; a plane is on the first", c.between);
    k.ends("a point of the wall, and the centre of the disc", c.at);
    k.axis("direction of the wall in the first body's frame; free space lies on its left", c.axis);
    k.take({"radius", "m", "radius of the disc; 0: a point"}, c.radius, non_negative);
    k.take({"stiffness", "N/m",
            "of the contact, for penalty contacts, required for a point; if absent: Hertz's, from the disc's "
            "radius and the surface"},
           c.stiffness, positive);
    k.surface({"surface", "", "the surface of the contact"}, c.surface);
  }
};

}  // namespace freeplay
