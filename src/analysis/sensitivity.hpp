// Derivatives of the results of a run with respect to keys of its scene and to its initial state
// (docs/theory/sensitivity.md).
//
// Usage:
//
//     const auto s = freeplay::sensitivities(
//         scene,
//         {.of = {"event.1.t", "end.ball.vy"}, .to = {"surfaces.steel.restitution", "initial.ball.y"}});
//     s.quantities[0].derivatives[1];  // d(time of the first contact)/d(initial height)
#pragma once

#include <string>
#include <vector>

#include "values/compile.hpp"
#include "values/sensitivity.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// Quantities and keys of a sensitivity analysis.
struct SensitivityRequest {
  /// event.N.t, event.N.v_n_minus, event.N.impulse_n, end.COLUMN, mean.COLUMN, peak.CHANNEL or energy.KEY
  std::vector<std::string> of;
  /// Keys of the scene with one number; a number within a list is NAME[i] or NAME[i][j], counted from 0.
  /// Or initial.COLUMN, a coordinate or rate of a body at the start.
  std::vector<std::string> to;
  std::string formulation = "nonsmooth";  ///< "penalty" or "nonsmooth"
  /// Stop request; the function then throws Interrupted.
  StopToken stop = {};
  /// Whether errors are estimated, which takes further runs (docs/theory/sensitivity.md).
  bool errors = true;
  /// `never`: derivatives by keys are differences of right-hand sides (docs/theory/compiled.md).
  Compile compile = Compile::automatic;
};

/// Runs the scene and returns the quantities with all derivatives and their errors. A derivative that does
/// not exist is NaN, with a reason. Throws ModelError for an unknown quantity or key and for a scheme without
/// derivatives.
Sensitivities sensitivities(const Scene& scene, const SensitivityRequest& request);

/// Standard deviation of a quantity, to first order, if the keys have independent errors with these standard
/// deviations (SI, one for each key): the root of Σ (dQ/dp σ_p)². NaN without a derivative by a key whose
/// deviation is not 0.
double propagated_deviation(const Sensitivity& quantity, const std::vector<double>& deviations);

}  // namespace freeplay
