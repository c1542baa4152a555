// Translational joint, ideal or loose: the second body slides along an axis of the first without turning
// relative to it.
//
//     ideal    no offset across the axis, a fixed relative angle:  two rows
//     loose    the four corners of a rectangle between two walls: four contacts (pairs/line.hpp)
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "mechanism/body.hpp"

namespace freeplay {

/// Play of a translational joint: a rectangular slider, centred on the second body's point, between two
/// parallel walls of the first body. Its four corners can touch.
struct SliderClearance {
  double half_play = 0;           ///< m, > 0: half the distance of the walls less half the slider's height
  double length = 0, height = 0;  ///< m, of the slider along and across the axis, > 0
  std::optional<double> corner_radius =
      {};            ///< m, of the rounded corners: for the stiffness of penalty contacts
  int surface = -1;  ///< index into Mechanism::surfaces
};

struct TranslationalJoint {
  static constexpr std::string_view type = "translational";
  std::string name;
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  Vec2 axis{1, 0};                                ///< unit vector in the first body's frame
  double angle = 0;                               ///< rad, θ of the second body less θ of the first
  std::optional<SliderClearance> clearance = {};  ///< absent: an ideal joint

  std::string_view what() const {
    return clearance ? "a translational joint" : "a translational joint without clearance";
  }

  static void keys(auto& k, auto& j) {
    k.between("two bodies, or \"ground\" and a body", j.between);
    k.ends("the joint's point in each body's frame, from its centre of mass; ground: world", j.at);
    k.axis("direction of sliding in the first body's frame", j.axis);
    k.take({"angle", "rad", "angle of the second body less that of the first"}, j.angle);
    if (auto* c = k.group("clearance", j.clearance)) {
      k.need({"clearance", "m", "half the play between a rectangular slider and its walls; left out: ideal"},
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
