// A round pin of the second body in a straight slot of the first, ideal or with clearance. The ends
// of the slot are a travel stop (elements/travel_stop.hpp).
//
//     ideal            no offset across the slot:      one row
//     with clearance   the pin between two walls:      two contacts (dynamics/pairs.hpp)
#pragma once

#include <array>
#include <optional>
#include <string>

#include "mechanism/body.hpp"

namespace freeplay {

/// Clearance of a pin in a slot.
struct SlotClearance {
  double half_play = 0;   ///< m, > 0: half the slot's width minus the pin's radius
  double pin_radius = 0;  ///< m, > 0
  int surface = -1;       ///< index into Mechanism::surfaces
};

/// A pin in a straight slot, ideal or with clearance.
struct SlotJoint {
  static constexpr std::string_view type = "slot";
  std::string name;                            ///< of the element in the scene
  std::array<int, 2> between{ground, ground};  ///< first and second body: indices, or ground
  /// a point of the slot's centre line, the pin's centre
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  /// Unit vector along the slot, in the first body's frame.
  Vec2 axis{1, 0};
  std::optional<SlotClearance> clearance = {};  ///< empty: an ideal joint

  std::string_view what() const { return clearance ? "a slot" : "a slot without clearance"; }

  static void keys(auto& k, auto& j) {
    k.between("two bodies, or \"ground\" and a body", j.between);
    k.ends("a point of the slot's middle line, and the pin's centre", j.at);
    k.axis("direction of the slot in the first body's frame", j.axis);
    if (auto* c = k.group("clearance", j.clearance)) {
      k.need({"clearance", "m", "half the slot's width less the pin's radius; if absent: ideal"},
             c->half_play, positive);
      k.need({"pin_radius", "m", "radius of the pin, on the second body"}, c->pin_radius, positive);
      k.surface({"surface", "", "the surface of its contacts"}, c->surface);
    }
  }
};

}  // namespace freeplay
