// Perturbed starts: the same scene, its crank at a random angle and its loose parts at random places within
// their play. The state is one of the ideal mechanism whose closed joints are moved by the offsets, so every
// other constraint holds and the relative velocities of the loose parts vanish.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mechanism/error.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

struct Perturbation {
  double turn = 1;    ///< share of a turn that the crank's angle is drawn from
  double play = 0.9;  ///< share of the clearance that offsets are drawn from, < 1
};

/// Whether starts of a scene may differ: it has a drive of prescribed speed to turn and `how` turns it, or loose parts
/// to place.
bool differ(const Scene& scene, const Perturbation& how);
/// A scene whose starts cannot differ, where statistics over starts are asked for.
class AlikeStarts : public SceneError {
  using SceneError::SceneError;
};
/// Throws AlikeStarts where they do not; `use` ends the message: what to do instead.
void require_differing_starts(const Scene& scene, const Perturbation& how, const std::string& use = "");

/// The scene at start number `start` (from 0) of `seed`: equal arguments give equal bits. The drive's angle
/// at t = 0 moves along. A scene without a drive of prescribed speed keeps its angle. Throws SceneError when
/// the ideal mechanism cannot be assembled or moved.
Scene perturbed(const Scene& scene, const StopToken& stop, std::uint64_t seed, int start,
                const Perturbation& how);
/// The same, of many starts: `near` is the scene's near_pose().
Scene perturbed(const Scene& scene, const std::vector<double>& near, const StopToken& stop,
                std::uint64_t seed, int start, const Perturbation& how);

}  // namespace freeplay
