// Dynamics of mechanism/elements/rack_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/gear_joint.hpp"
#include "dynamics/mesh.hpp"
#include "mechanism/elements/rack_joint.hpp"

namespace freeplay {

template <>
struct Dynamics<RackJoint> : RackJoint {
  void build(auto& b) const {
    if (!phase) return;
    if (between[0] != ground) b.reach(pitch_radius);
    build_teeth<RackMesh>(b, *this, std::sin(pressure_angle) * pitch_radius);
  }
};

}  // namespace freeplay
