// Least squares of correlated residuals, for fits of time series. The unknowns ξ ∈ [−1, 1]ⁿ minimise
//
//     S(ξ) = Σ_s |r_s(ξ)|²,
//
// with the residuals r_s of each series at its samples, by Levenberg and Marquardt's method (Marquardt, J.
// Soc. Indust. Appl. Math. 11 (1963) 431) from the best of a space-filling set of points. Derivatives are
// central differences, because runs with contact and friction need not have others.
//
// Neighbouring samples of a residual are not independent: a model that misses a loop misses it at many
// samples. With the autocovariance c_s(k) of each residual and J_s = ∂r_s/∂ξ, the covariance of ξ is
//
//     V = (ΣJᵀJ)⁻¹ M (ΣJᵀJ)⁻¹,   M = Σ_s Σ_ij c_s(|i − j|) J_siᵀ J_sj,
//
// at least that of independent residuals. c_s is taken up to the first pair of lags with a sum ≤ 0 (Geyer,
// Statist. Sci. 7 (1992) 473). With τ_s = 1 + 2 Σ c_s(k)/c_s(0) over these lags, a series of N_s samples
// counts as N_s/τ_s independent ones. The 95 % interval of ξ_j is ξ_j ± t_ν(0.975) √V_jj, ν = Σ N_s/τ_s −
// n; for ν < 1 there is none. It covers the error of a stationary residual. It does not cover a systematic
// error of the model, which repeats in each cycle.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace freeplay {

/// Residuals of each fitted series at one point; empty: a run of this point has failed.
using SeriesResiduals = std::vector<Eigen::VectorXd>;
/// Residuals at several points ξ, which may be computed together.
using ResidualsAt = std::function<std::vector<SeriesResiduals>(const std::vector<Eigen::VectorXd>& points)>;

/// Autocovariance of a residual at the lags from 0 to the first pair with a sum ≤ 0, without that pair.
std::vector<double> autocovariance(const Eigen::VectorXd& residual);
/// τ of such a list, ≥ 1, in samples.
double correlation_samples(const std::vector<double>& autocovariance);

/// Result of a fit.
struct SeriesEstimate {
  Eigen::VectorXd xi;
  Eigen::MatrixXd covariance;  ///< V
  double squares = 0;          ///< S
  double independent = 0;      ///< Σ N_s/τ_s
  /// ± of the 95 % interval of an unknown is `quantile` √V_jj; NaN: ν < 1.
  double quantile = 0;
  int iterations = 0;
  /// Whether the Gauss-Newton step at ξ is below a tenth of the standard deviation of every unknown that is
  /// not at a bound.
  bool converged = false;
};

/// Fits `unknowns` unknowns. Throws std::runtime_error if no run of the space-filling set succeeds.
SeriesEstimate estimate_series(const ResidualsAt& residuals, int unknowns);

}  // namespace freeplay
