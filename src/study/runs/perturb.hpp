// Perturbed starts: the same scene with its crank at a random angle and its joints with clearance
// at random positions within it. The state is computed as that of the ideal mechanism whose closed
// joints are displaced by these offsets. All other constraints hold, and the relative velocities
// within the clearances vanish. Then chosen initial values are varied (initial_value.hpp).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mechanism/error.hpp"
#include "study/runs/initial_value.hpp"
#include "values/stop.hpp"

namespace freeplay {

// Initial guess of the positions for perturbed starts. If the ideal mechanism closes in isolated
// poses (as many independent constraint rows, including drives, as coordinates), its pose for the
// given joints is close to the pose for joints displaced within their clearance. Newton's method
// then leads from one to the other without a nonlinear program:
//
//     q ← q − M⁻¹Gᵀ (G M⁻¹ Gᵀ)⁻¹ Φ(q),   G square,   starting from the initial guess.
//
// If the mechanism has degrees of freedom left, the pose nearest to the given positions is computed
// instead (src/dynamics/assembly/assembly.hpp).

struct Scene;
struct SharedResults;

/// q (m, rad) of the ideal mechanism. Empty if it has degrees of freedom, cannot be closed, or if
/// the scene prescribes the positions. Throws Interrupted.
std::vector<double> ideal_pose(const Scene& scene, const StopToken& stop);

/// Likewise, computed once for each distinct ideal mechanism.
std::vector<double> ideal_pose(const Scene& scene, const StopToken& stop, SharedResults& shared);

/// Size of the perturbations.
struct Perturbation {
  double turn = 1;                      ///< crank angles are drawn from this share of a turn
  double play = 0.9;                    ///< offsets are drawn from this share of the clearance, < 1
  std::vector<InitialValue> vary = {};  ///< drawn last: without them, starts keep their bits
};

/// Whether starts of a scene can differ: it has a drive of prescribed speed and `how` turns it, it
/// has joints with clearance, or `how` varies initial values.
bool differ(const Scene& scene, const Perturbation& how);
/// Thrown if statistics over starts are requested for a scene whose starts cannot differ.
class AlikeStarts : public SceneError {
  using SceneError::SceneError;
};
/// Throws AlikeStarts if starts cannot differ; `use` ends the message with a remedy.
void require_differing_starts(const Scene& scene, const Perturbation& how, const std::string& use = "");

/// Throws SceneError if an initial value cannot be varied: its range is tried at both ends, alone and
/// without play. `near` is the scene's ideal_pose().
void require_variable(const Scene& scene, const std::vector<double>& near, const StopToken& stop,
                      const std::vector<InitialValue>& values);

/// The scene at start number `start` (from 0) of `seed`. Equal arguments give equal bits. The
/// drive's angle at t = 0 is changed accordingly; a scene without a drive of prescribed speed keeps
/// its angle. Throws SceneError if the ideal mechanism cannot be assembled or moved.
Scene perturbed(const Scene& scene, const StopToken& stop, std::uint64_t seed, int start,
                const Perturbation& how);
/// As above, for many starts: `near` is the scene's ideal_pose().
Scene perturbed(const Scene& scene, const std::vector<double>& near, const StopToken& stop,
                std::uint64_t seed, int start, const Perturbation& how);

}  // namespace freeplay
