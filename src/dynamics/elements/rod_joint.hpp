// Dynamics of mechanism/elements/rod_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/rod_joint.hpp"

namespace freeplay {

template <>
struct Dynamics<RodJoint> : RodJoint {
  void build(auto& b) const {
    b.reach(length);
    b.distance(b.link(between, at), length, name);
  }
};

}  // namespace freeplay
