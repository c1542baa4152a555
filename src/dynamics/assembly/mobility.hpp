// Whether the ideal mechanism can be closed over a full turn of its main drive (Grashof's question
// for any mechanism). The mechanism is followed through 72 positions of the turn, each from the
// previous pose by the best pose of closure.hpp with the drives held. If the best pose stays open
// by more than the sum of the joints' clearances, the preceding interval is halved until the
// position is known to 1e-3 of an interval. turn_survey.hpp follows the turn in the same way.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/assembly/closure.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Mechanism;
class System;

/// Greatest number of bodies for which a turn is followed; it then takes less than a second.
inline constexpr std::size_t most_followed = 100;

/// Closed poses at increasing or decreasing times of the drives.
struct FollowedTurn {
  std::vector<double> t;               ///< s
  std::vector<std::vector<double>> q;  ///< the pose at each time
  std::optional<OpenJoint> open = {};  ///< greatest gap beyond the last pose; empty: none
};

/// How a turn is followed.
struct Following {
  double length = 1;    ///< m, to which errors are related: converts angles
  double allowed = 0;   ///< m, sum of gaps up to which a pose counts as closed
  double interval = 0;  ///< s, of either sign
  int intervals = 0;
  double resolution = 1e-3;  ///< to which the end is located, relative to an interval
};

/// Follows a mechanism from its closed pose q at t = 0. At most 800 poses are solved for.
FollowedTurn follow_turn(const System& system, std::vector<double> q, const Following& how);

/// A position of the main drive beyond which the mechanism cannot be closed.
struct DeadPoint {
  double t = 0;      ///< s, of the main drive from its start
  double angle = 0;  ///< rad, rotation of the main drive up to it
  OpenJoint open;    ///< the greatest gap just beyond it
};

/// A start of the ideal mechanism, as assemble() returns it with what it assumed.
struct IdealStart {
  State state;
  std::string assumed;
};

/// The first dead point within a turn of the main drive and `duration` (s). Empty if the turn
/// closes, if no drive has a constant speed, if the ideal mechanism has no start, and for more than
/// most_followed bodies. `start` receives the start from which the turn is followed.
std::optional<DeadPoint> dead_point(const Mechanism& mechanism, double duration,
                                    std::optional<IdealStart>* start = nullptr);

// Motions of a mechanism that no drive prescribes. With ideal joints and all prescribed motions
// held, the virtual displacements are the null space of G. A joint coordinate σ with gradient w is
// free if its response a = P M⁻¹wᵀ is not zero, P being the projection onto that space in the
// metric of M. Each free coordinate found is held in turn (Gram–Schmidt in that metric), so that
// the coordinates found are independent and together determine all undriven motions.

struct UndrivenMotions {
  std::vector<int> bodies;               ///< that can move
  std::vector<std::string> coordinates;  ///< independent ones, such as "rotation at elbow"
};

/// The undriven motions at q. Joints with the ground come first, then other joints, then the
/// coordinates of bodies ("x of block").
UndrivenMotions undriven_motions(const Mechanism& mechanism, const std::vector<double>& q);

}  // namespace freeplay
