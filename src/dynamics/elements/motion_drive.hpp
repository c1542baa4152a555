// Dynamics of mechanism/elements/motion_drive.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/motion_drive.hpp"
#include "mechanism/piecewise.hpp"

namespace freeplay {

template <>
struct Dynamics<MotionDrive> : MotionDrive {
  auto link(auto& b) const { return b.joint_link(joint); }
  void build(auto& b) const {
    const auto& m = b.mechanism();
    const Vec2* axis = slides(m) ? &std::get<TranslationalJoint>(m.joints[joint]).axis : nullptr;
    b.motion(link(b), course(m.curves), axis, of, name);
  }
};

}  // namespace freeplay
