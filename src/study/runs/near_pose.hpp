// Initial guess of the positions for perturbed starts. If the ideal mechanism closes in isolated
// poses (as many independent constraint rows, including drives, as coordinates), its pose for the
// given joints is close to the pose for joints displaced within their clearance. Newton's method
// then leads from one to the other without a nonlinear program:
//
//     q ← q − M⁻¹Gᵀ (G M⁻¹ Gᵀ)⁻¹ Φ(q),   G square,   starting from the initial guess.
//
// If the mechanism has degrees of freedom left, the pose nearest to the given positions is computed
// instead (src/dynamics/assembly/assembly.hpp).
#pragma once

#include <vector>

#include "values/stop.hpp"

namespace freeplay {

struct Scene;
struct SharedResults;

/// q (m, rad) of the ideal mechanism. Empty if it has degrees of freedom, cannot be closed, or if
/// the scene prescribes the positions. Throws Interrupted.
std::vector<double> near_pose(const Scene& scene, const StopToken& stop);

/// Likewise, computed once for each distinct ideal mechanism.
std::vector<double> near_pose(const Scene& scene, const StopToken& stop, SharedResults& shared);

}  // namespace freeplay
