// Dynamics of mechanism/elements/gear_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/mesh.hpp"
#include "mechanism/elements/gear_joint.hpp"

namespace freeplay {

/// The row of an ideal pair of teeth, or a contact for each flank. `radius` (m): of Hertz's contact.
template <class Mesh>
void build_teeth(auto& b, const auto& joint, double radius) {
  const auto link = b.link(joint.between, joint.at);
  if (!joint.clearance) return b.mesh(link, Mesh{joint.mesh(side_of(joint.flank), 0)}, joint.name);
  const auto& c = *joint.clearance;
  for (const auto side : {Flank::forward, Flank::backward}) {
    auto facts = b.facts(joint.name + "." + std::string(text_of(side)), joint.between, c.surface);
    facts.clearance = 0.5 * c.normal;
    facts.has_clearance = true;
    facts.radius = radius;
    facts.stiffness = c.stiffness;
    b.flank(link, Mesh{joint.mesh(side_of(side), c.normal)}, facts);
  }
}

template <>
struct Dynamics<GearJoint> : GearJoint {
  void build(auto& b) const {
    if (!phase) return;
    for (const int which : {0, 1})
      if (between[which] != ground) b.reach(pitch(which));
    const double kind = internal ? -1 : 1, r0 = pitch(0), r1 = pitch(1);
    build_teeth<InvoluteMesh>(b, *this, std::sin(pressure_angle) * r0 * r1 / (r0 + kind * r1));
  }
};

}  // namespace freeplay
