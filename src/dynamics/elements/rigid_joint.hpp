// Dynamics of mechanism/elements/rigid_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/rigid_joint.hpp"

namespace freeplay {

template <>
struct Dynamics<RigidJoint> : RigidJoint {
  void build(auto& b) const {
    const auto link = b.link(between, at);
    b.points(link, name);
    b.angle(link, angle, name);
  }
};

}  // namespace freeplay
