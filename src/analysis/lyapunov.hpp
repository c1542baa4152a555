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
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// Options of lyapunov().
struct LyapunovRequest {
  std::string formulation = "nonsmooth";  ///< or "penalty"
  int batches = 20;                       ///< number of batch means, ≥ 4
  /// s, excluded at the beginning; default: run.discard, at least a tenth of the run
  std::optional<double> transient = {};
  /// Number of exponents, the greatest ones; 0: all. Without all there is no predicted sum.
  int exponents = 0;
  /// s, > 0: the motion repeats after this time. Each batch then is one cycle, and its exponents are
  /// ln|μ|/cycle of the multipliers μ; the run ends after the batches.
  double cycle = 0;
  std::optional<State> start = {};  ///< instead of that of run.start
  /// Stop request; the function then throws Interrupted.
  StopToken stop = {};
};

/// Fewest batches from which standard errors are formed.
inline constexpr int fewest_batches = 4;

/// The exponents of the scene's motion over its duration. If there are none, Lyapunov::failure has the
/// reason. Throws ModelError for a scheme without derivatives and for wrong options.
Lyapunov lyapunov(const Scene& scene, const LyapunovRequest& request = {});

/// Throws ModelError if the exponents of runs of this scene are not available.
void require_exponents(const Scene& scene, const std::string& formulation);

}  // namespace freeplay
