// Whether the ideal mechanism can be closed over a full turn of its main drive (Grashof's question
// for any mechanism). The mechanism is followed through 72 positions of the turn, each from the
// previous pose by the best pose of closure.hpp with the drives held. If the best pose stays open
// by more than the sum of the joints' clearances, the preceding interval is halved until the
// position is known to 1e-3 of an interval.
#pragma once

#include <optional>

#include "dynamics/assembly/closure.hpp"

namespace freeplay {

struct Mechanism;

/// Greatest number of bodies for which a turn is followed; it then takes less than a second.
inline constexpr std::size_t most_followed = 100;

/// A position of the main drive beyond which the mechanism cannot be closed.
struct DeadPoint {
  double t = 0;      ///< s, of the main drive from its start
  double angle = 0;  ///< rad, rotation of the main drive up to it
  OpenJoint open;    ///< the greatest gap just beyond it
};

/// The first dead point within a turn of the main drive and `duration` (s). Empty if the turn
/// closes, if no drive has a constant speed, if the ideal mechanism has no start, and for more than
/// most_followed bodies.
std::optional<DeadPoint> dead_point(const Mechanism& mechanism, double duration);

}  // namespace freeplay
