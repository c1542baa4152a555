// Dynamics of mechanism/elements/ratio_joint.hpp, which states the equations.
#pragma once

#include <cmath>

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/ratio_joint.hpp"

namespace freeplay {

template <>
struct Dynamics<RatioJoint> : RatioJoint {
  void build(auto& b) const {
    const auto* slides = slider(b.mechanism());
    if (clearance)
      build_contacts(b, slides);
    else
      b.ratio(b.joint_link(joint), ratio, offset, slides ? &slides->axis : nullptr, of, name);
  }

 private:
  /// The contact "forward" closes where the joint `of` pushes y upwards: g = R (b/2 + σ (y − r θ − offset)),
  /// with R = 1 for a position and σ = 1 forward, −1 backward.
  void build_contacts(auto& b, const TranslationalJoint* slides) const {
    const auto& c = *clearance;
    const auto leads = b.joint_link(of), follows = b.joint_link(joint);
    const auto bodies = coupled(b.mechanism(), joint, of);
    // Of an angle θ_second − θ_first whose other body is the ground.
    const auto sign = [](const Link& link) { return link.j == ground ? -1.0 : 1.0; };
    const double R = slides ? 1 : c.radius;
    if (!slides) b.reach(R);
    for (const double side : {1.0, -1.0}) {
      auto facts = b.facts(name + (side > 0 ? ".forward" : ".backward"), bodies, c.surface);
      facts.clearance = 0.5 * c.play * R;
      facts.has_clearance = true;
      facts.stiffness = c.stiffness;
      RatioPair pair{{bodies[0], bodies[1], {0, 0}, slides ? follows.sj : Vec2{0, 0}}};
      pair.rest = R * (0.5 * c.play - side * offset);
      pair.turn_i = -side * R * ratio * sign(leads);
      if (slides) {
        pair.along = side * slides->axis;
        pair.rest -= dot(pair.along, follows.si);
      } else {
        pair.turn_j = side * R * sign(follows);
      }
      b.pair(pair, facts);
    }
  }
};

}  // namespace freeplay
