// Whether the ideal mechanism closes over a turn of its main drive (E. Grashof's question, of any mechanism). It is followed
// through 72 places of the turn, each from the pose before it by closure.hpp's best pose with the drives held. Where the
// best pose stays open by more than the joints' clearances together, the arc before it is halved until the place is known
// to 1e-3 of such a step.
#pragma once

#include <optional>

#include "dynamics/assembly/closure.hpp"

namespace freeplay {

struct Mechanism;

/// Up to as many bodies a turn takes less than a second to follow.
inline constexpr std::size_t most_followed = 100;

/// Where a turn ends that cannot be gone on with.
struct DeadPoint {
  double t = 0;      ///< s, of the main drive from its start
  double angle = 0;  ///< rad, that the main drive has turned by then
  OpenJoint open;    ///< what stays open just behind it
};

/// The first dead point within a turn of the main drive and `duration` (s); none where the turn closes, where no drive turns
/// at a constant speed, where the ideal mechanism has no start, and for more than most_followed bodies.
std::optional<DeadPoint> dead_point(const Mechanism& mechanism, double duration);

}  // namespace freeplay
