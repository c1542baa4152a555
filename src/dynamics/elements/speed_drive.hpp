// Dynamics of mechanism/elements/speed_drive.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/speed_drive.hpp"

namespace freeplay {

template <>
struct Dynamics<SpeedDrive> : SpeedDrive {
  auto link(auto& b) const { return b.joint_link(joint); }
  void build(auto& b) const { b.prescribed(link(b), initial_angle, speed, name); }
};

}  // namespace freeplay
