// Dynamics of mechanism/elements/rack_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/mesh.hpp"
#include "mechanism/elements/rack_joint.hpp"

namespace freeplay {

template <>
struct Dynamics<RackJoint> : RackJoint {
  void build(auto& b) const {
    if (!phase) return;
    const auto link = b.link(between, at);
    if (between[0] != ground) b.reach(pitch_radius);
    if (!clearance) return b.mesh(link, RackMesh{mesh(side_of(flank), 0)}, name);
    const auto& c = *clearance;
    for (const auto side : {Flank::forward, Flank::backward}) {
      auto facts = b.facts(name + "." + std::string(text_of(side)), between, c.surface);
      facts.clearance = 0.5 * c.normal;
      facts.has_clearance = true;
      facts.radius = std::sin(pressure_angle) * pitch_radius;
      facts.stiffness = c.stiffness;
      b.flank(link, RackMesh{mesh(side_of(side), c.normal)}, facts);
    }
  }
};

}  // namespace freeplay
