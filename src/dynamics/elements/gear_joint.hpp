// Dynamics of mechanism/elements/gear_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/mesh.hpp"
#include "mechanism/elements/gear_joint.hpp"

namespace freeplay {

template <>
struct Dynamics<GearJoint> : GearJoint {
  void build(auto& b) const {
    if (!phase) return;
    const auto link = b.link(between, at);
    for (const int which : {0, 1})
      if (between[which] != ground) b.reach(pitch(which));
    if (!clearance) return b.mesh(link, InvoluteMesh{mesh(side_of(flank), 0)}, name);
    const auto& c = *clearance;
    const double kind = internal ? -1 : 1, r0 = pitch(0), r1 = pitch(1);
    for (const auto side : {Flank::forward, Flank::backward}) {
      auto facts = b.facts(name + "." + std::string(text_of(side)), between, c.surface);
      facts.clearance = 0.5 * c.normal;
      facts.has_clearance = true;
      facts.radius = std::sin(pressure_angle) * r0 * r1 / (r0 + kind * r1);
      facts.stiffness = c.stiffness;
      b.flank(link, InvoluteMesh{mesh(side_of(side), c.normal)}, facts);
    }
  }
};

}  // namespace freeplay
