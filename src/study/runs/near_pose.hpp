// Where a search for perturbed starts begins. Of an ideal mechanism that closes in isolated poses (as many independent constraint
// rows, drives included, as coordinates) the pose of its joints as given is near that of joints moved within their play, so that Newton's
// method goes from the one to the other and no nonlinear program need be solved:
//
//     q ← q − M⁻¹Gᵀ (G M⁻¹ Gᵀ)⁻¹ Φ(q),   G square,   begun at the near pose.
//
// Where the mechanism has freedom left, the pose nearest to the positions given is sought from these, as by src/dynamics/assembly/assembly.hpp.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// q of the ideal mechanism; none where it has freedom, does not close, or the scene's own places hold. Throws Interrupted.
std::vector<double> near_pose(const Scene& scene, const StopToken& stop);

/// Of each distinct ideal mechanism once, whoever asks.
class NearPoses {
 public:
  std::vector<double> operator()(const Scene& scene, const StopToken& stop);

 private:
  std::mutex mutex_;
  std::map<std::string, std::vector<double>> found_;  // by the digest of the identity
};

}  // namespace freeplay
