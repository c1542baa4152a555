// Dynamics of mechanism/elements/slot_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/slot_joint.hpp"

namespace freeplay {

template <>
struct Dynamics<SlotJoint> : SlotJoint {
  void build(auto& b) const {
    const auto link = b.link(between, at);
    if (!clearance) return b.slide(link, axis, name);
    const auto& c = *clearance;
    for (const int side : {1, -1}) {
      auto facts = b.facts(name + (side > 0 ? ".right" : ".left"), between, c.surface);
      facts.clearance = c.half_play;
      facts.has_clearance = true;
      facts.radius = c.pin_radius;
      b.line(link, side, axis, -c.half_play, c.pin_radius, facts);
    }
  }
};

}  // namespace freeplay
