// Dynamics of mechanism/elements/translational_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/translational_joint.hpp"

namespace freeplay {

template <>
struct Dynamics<TranslationalJoint> : TranslationalJoint {
  void build(auto& b) const {
    if (clearance) return build_corners(b);
    const auto link = b.link(between, at);
    b.slide(link, axis, name);
    b.angle(link, angle, name);
  }

 private:
  void build_corners(auto& b) const {
    const auto& c = *clearance;
    // Axes of the slider in its body's frame.
    const double turn = -angle;
    const Vec2 along{std::cos(turn) * axis.x() - std::sin(turn) * axis.y(),
                     std::sin(turn) * axis.x() + std::cos(turn) * axis.y()};
    const Vec2 across = perp(along);
    struct Corner {
      const char* name;
      double x, y;
    };
    for (const auto& [corner_name, x, y] :
         {Corner{"rear_lower", -0.5, -0.5}, Corner{"rear_upper", -0.5, 0.5}, Corner{"front_lower", 0.5, -0.5},
          Corner{"front_upper", 0.5, 0.5}}) {
      const Vec2 corner = at[1] + x * c.length * along + y * c.height * across;
      auto facts = b.facts(name + "." + corner_name, between, c.surface);
      facts.clearance = c.half_play;
      facts.has_clearance = true;
      facts.radius = c.corner_radius.value_or(0);
      b.line(b.link(between, {at[0], corner}), y < 0 ? 1 : -1, axis, -(0.5 * c.height + c.half_play), 0,
             facts);
    }
  }
};

}  // namespace freeplay
