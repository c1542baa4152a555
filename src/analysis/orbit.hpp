// Periodic motions and their stability (docs/theory/orbits.md).
//
// Usage:
//
//     const auto found = freeplay::orbit(scene, {.periods = 2, .settle = 20});
//     if (found.failure.empty() && found.stable) use(found.multipliers.front());
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "values/orbit.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// Which periodic motion is searched.
struct OrbitRequest {
  std::string formulation = "nonsmooth";  ///< "penalty" or "nonsmooth"
  int periods = 1;                        ///< periods of the drive after which the state returns, ≥ 1
  /// Periods of the drive from the scene's start to the section, ≥ 0; a fraction selects the phase
  /// of the section.
  double settle = 10;
  /// s; default: that of the drives. For a mechanism without a drive, an estimate, which is required.
  std::optional<double> period = {};
  /// Coordinates (BODY.x, BODY.y, BODY.theta, or x or y of all bodies) that may all have changed by the
  /// same amount after the periods, as the heights of a mechanism that descends a uniform pole. This
  /// shift must leave all forces and gaps as they are.
  std::vector<std::string> shift = {};
  /// Stop request; the function then throws Interrupted.
  StopToken stop = {};
};

/// Searches a periodic motion near the scene's motion after `settle` periods. If none is found,
/// Orbit::failure has the reason. Throws ModelError if the period is not known, and if a shift is
/// no symmetry.
Orbit orbit(const Scene& scene, const OrbitRequest& request = {});

}  // namespace freeplay
