// The argument x of a curve y(x) of a drive or load: time, angle or position of the driven part,
// its speed, or the angle of another joint (gas force on a piston against the crank angle).
#pragma once

#include "mechanism/keys.hpp"

namespace freeplay {

/// Argument of a curve: time (s), angle (rad), position (m), or speed (rad/s, m/s).
enum class Argument { time, angle, position, speed };
inline constexpr auto argument_names =
    complete<Argument>({{Argument::time, "time", "s"},
                        {Argument::angle, "angle", "rad, of a revolute joint"},
                        {Argument::position, "position", "m, of a translational joint"},
                        {Argument::speed, "speed", "rad/s or m/s, of the same"}});
constexpr std::span<const Choice<Argument>> choices(Argument) { return argument_names; }

/// The joint whose angle is the argument, if it is not the element's own joint.
struct OtherJoint {
  int of = -1;  ///< index into Mechanism::joints; −1: none

  static void keys(auto& k, auto& o, Argument against, bool reads) {
    if (k.when(reads && against == Argument::angle, {"of"}, "goes with a curve against = \"angle\""))
      k.maybe_joint({"of", "", "revolute joint whose angle the curve is read against; if absent: its own"},
                    o.of);
  }
};

}  // namespace freeplay
