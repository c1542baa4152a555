// Mechanisms whose prescribed motions are held.
#pragma once

#include <optional>
#include <string>

#include "mechanism/mechanism.hpp"

namespace freeplay {

/// A joint whose motion a drive prescribes, and its coordinate (rad or m) at t = 0; −1: none.
struct PrescribedJoint {
  int joint = -1;
  double start = 0;
};

/// The joint that a drive moves; empty if the drive prescribes no motion or one that follows another joint.
std::optional<PrescribedJoint> prescribed_joint(const Drive& drive, const Mechanism& mechanism);

/// The mechanism with all prescribed motions held at their places at t = 0, but for `over` (−1: none): it is held
/// at `place`, or its coordinate is t if that is empty.
Mechanism held(Mechanism mechanism, int over, std::optional<double> place);

/// The driven joint of this name; without a name that of the crank angle, if its motion is prescribed. Throws
/// ModelError that lists such joints.
PrescribedJoint driven_joint(const Mechanism& mechanism, const std::string& name);

}  // namespace freeplay
