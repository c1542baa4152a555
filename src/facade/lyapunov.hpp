// Lyapunov exponents of a motion with impacts (docs/theory/lyapunov.md).
//
// Usage:
//
//     const auto found = freeplay::lyapunov(scene, {.batches = 20});
//     if (found.failure.empty()) use(found.exponents.front().value, found.exponents.front().error);
#pragma once

#include <optional>
#include <string>

#include "values/lyapunov.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// Options of lyapunov().
struct LyapunovRequest {
  std::string formulation = "nonsmooth";  ///< "nonsmooth"; others are refused
  int batches = 20;                       ///< number of batch means, ≥ 4
  /// s, excluded at the beginning; default: run.discard, at least a tenth of the run
  std::optional<double> transient = {};
  /// Stop request; the function then throws Interrupted.
  StopToken stop = {};
};

/// Fewest batches from which standard errors are formed.
inline constexpr int fewest_batches = 4;

/// The exponents of the scene's motion over its duration. If there are none, Lyapunov::failure has the
/// reason. Throws ModelError for a scheme without derivatives and for wrong options.
Lyapunov lyapunov(const Scene& scene, const LyapunovRequest& request = {});

}  // namespace freeplay
