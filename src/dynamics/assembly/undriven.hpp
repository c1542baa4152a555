// Motions of a mechanism that no drive prescribes. With ideal joints and all prescribed motions
// held, the virtual displacements are the null space of G. A joint coordinate σ with gradient w is
// free if its response a = P M⁻¹wᵀ is not zero, P being the projection onto that space in the
// metric of M. Each free coordinate found is held in turn (Gram–Schmidt in that metric), so that
// the coordinates found are independent and together determine all undriven motions.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Mechanism;

struct UndrivenMotions {
  std::vector<int> bodies;               ///< that can move
  std::vector<std::string> coordinates;  ///< independent ones, such as "rotation at elbow"
};

/// The undriven motions at q. Joints with the ground come first, then other joints, then the
/// coordinates of bodies ("x of block").
UndrivenMotions undriven_motions(const Mechanism& mechanism, const std::vector<double>& q);

}  // namespace freeplay
