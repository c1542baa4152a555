// Calibration to quantities of single runs, such as times and impulses of contact events. Until
// chaos dominates, these are smooth functions of the unknowns with exact derivatives
// (analysis/sensitivity.hpp). The misfit
//
//     f(ξ) = Σ ((Q_i(ξ) − m_i)/σ_i)² + w |ξ|²,     ξ ∈ [−1, 1]ⁿ,
//
// with the weak prior w of Misfit, is minimised by Ipopt with the Gauss-Newton Hessian
// 2 (JᵀJ + w), J_ij = ∂Q_i/∂ξ_j/σ_i.
//
// Contact events are added in the order of their numbers. Let C = (JᵀJ + w)⁻¹ from the events before, of
// those combinations of unknowns that they determine (JᵀJ ≥ w). Event N is used if the standard deviation
// √(gᵀCg) of its predicted time t_N, with g = ∂t_N/∂ξ, is at most a quarter of the intervals to its
// neighbours: beyond this horizon, the N-th event of the model need not be the N-th of the measurement. Later
// targets are predicted, not fitted.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "study/calibration/calibrate.hpp"

namespace freeplay {

/// A target of a QuantityFit.
struct FittedQuantity {
  double value = 0;      ///< of the model at the optimum; NaN if its run does not reach it
  double deviation = 0;  ///< σ of the measurement, SI
  /// Standard deviation of the model's value due to that of the unknowns.
  double model_deviation = 0;
  bool used = false;  ///< fitted; otherwise beyond the horizon
};

/// Result of a calibration to quantities.
struct QuantityFit : Optimum {
  std::vector<FittedQuantity> targets;  ///< in the order of the study
  std::vector<Estimate> unknowns;       ///< with 95 % intervals; none if the fit is rejected
  Eigen::MatrixXd correlation;          ///< of the unknowns
  double squares = 0;                   ///< Σ ((Q_i − m_i)/σ_i)² over the used targets
  int degrees = 0;                      ///< of χ²: used targets less unknowns
  bool rejected = false;                ///< `squares` exceeds the 99 % quantile of χ²
  int horizon = 0;                      ///< number of the last contact event used; 0: none
  bool beyond = false;                  ///< some targets lie beyond the horizon
  int runs = 0;                         ///< runs with derivatives
  int iterations = 0;                   ///< of Ipopt, over all stages
  /// The fit is not rejected and determines every unknown.
  bool holds() const { return !rejected && std::ranges::none_of(unknowns, &Estimate::open); }
};

/// Whether the targets are quantities of single runs. A study has either these or statistics.
bool fits_quantities(const Calibration& calibration);

/// Fits the unknowns of a study of such targets. `on_run` receives the number of runs. Throws
/// SceneError for a quantity or key that has no derivatives, and std::runtime_error, with the reason,
/// if no minimum is found.
QuantityFit fit_quantities(const Study& study, const StopToken& stop,
                           const std::function<void(int)>& on_run = {});

}  // namespace freeplay
