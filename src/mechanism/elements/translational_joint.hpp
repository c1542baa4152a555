// Translational joint, ideal or with clearance: the second body slides along an axis of the first
// without rotating relative to it.
//
//     ideal            no offset across the axis, a fixed relative angle:  two rows
//     with clearance   the four corners of a rectangle between two walls: four contacts
//                     (dynamics/pairs.hpp)
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "mechanism/body.hpp"

namespace freeplay {

/// Clearance of a translational joint. A rectangular slider, centred on the second body's point, is
/// between two parallel walls of the first body; each of its four corners is a contact.
struct SliderClearance {
  /// m, > 0: half the distance of the walls minus half the slider's height
  double half_play = 0;
  double length = 0, height = 0;  ///< m, of the slider along and across the axis, > 0
  /// m, of rounded corners, for the stiffness of penalty contacts
  std::optional<double> corner_radius = {};
  int surface = -1;  ///< index into Mechanism::surfaces
};

/// A slider on a straight guide, ideal or with clearance.
struct TranslationalJoint {
  static constexpr std::string_view type = "translational";
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< m, one point of each body, in its frame
  Vec2 axis{1, 0};                                 ///< unit vector in the first body's frame
  /// rad, θ of the second body minus θ of the first
  double angle = 0;
  std::optional<SliderClearance> clearance = {};  ///< empty: an ideal joint

  std::string_view what() const {
    return clearance ? "a translational joint" : "a translational joint without clearance";
  }

  static void keys(auto& k, auto& j) {
    k.between("two bodies, or \"ground\" and a body", j.between);
    k.ends("the joint's point in each body's frame, from its centre of mass; ground: world", j.at);
    k.axis("direction of sliding in the first body's frame", j.axis);
    k.take({"angle", "rad", "angle of the second body less that of the first"}, j.angle);
    if (auto* c = k.group("clearance", j.clearance)) {
      k.need({"clearance", "m",
              "half the clearance between a rectangular slider and its walls; if absent: "
              "ideal"},
             c->half_play, positive);
      k.need({"slider_length", "m", "the slider along the axis"}, c->length, positive);
      k.need({"slider_height", "m", "the slider across the axis"}, c->height, positive);
      k.take(
          {"corner_radius", "m", "rounding of the slider's corners, for the stiffness of penalty contacts"},
          c->corner_radius, positive);
      k.surface({"surface", "", "the surface of its contacts"}, c->surface);
    }
  }
};

}  // namespace freeplay
