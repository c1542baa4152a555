// Dyads of a mechanism: two bodies with a common joint J that two bodies of known motion carry, by
// a pin or a guide each (Assur groups of class II). A massless rod and a guided or pinned body are a
// dyad, too. Known are the ground, the bodies of prescribed motion, and in turn every body that
// joints to known bodies fix by three rows, and both bodies of a dyad.
#pragma once

#include <array>
#include <vector>

namespace freeplay {

struct Mechanism;

struct Dyad {
  int joint = -1;                ///< J: index into Mechanism::joints
  std::array<int, 2> bodies{};   ///< equal for a rod and a body
  std::array<int, 2> carried{};  ///< the joints that carry them; the rod itself for a rod
};

/// The dyads of an ideal mechanism, beginning at the ground.
std::vector<Dyad> dyads(const Mechanism& mechanism);

/// Transmission angle (rad, from 0 to π/2) of a dyad in the pose q (turn_survey.hpp).
double transmission_angle(const Mechanism& mechanism, const Dyad& dyad, const std::vector<double>& q);

}  // namespace freeplay
