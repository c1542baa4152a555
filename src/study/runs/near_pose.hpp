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

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// q (m, rad) of the ideal mechanism. Empty if it has degrees of freedom, cannot be closed, or if
/// the scene prescribes the positions. Throws Interrupted.
std::vector<double> near_pose(const Scene& scene, const StopToken& stop);

/// Cache of near_pose() for each distinct ideal mechanism. Safe for concurrent use.
class NearPoses {
 public:
  std::vector<double> operator()(const Scene& scene, const StopToken& stop);

 private:
  std::mutex mutex_;
  std::map<std::string, std::vector<double>> found_;  // by the digest of the identity
};

}  // namespace freeplay
