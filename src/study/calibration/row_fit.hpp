// Fits of unknowns to rows of measured runs (study/settings/measured_rows.hpp), and predictions of rows that
// were held out. With y_ik the measured quantities of row i, x_ik(ξ) those of its run and w_k their weights,
// a row has the residual
//
//     r_i(ξ) = |d_i(ξ)|,     d_ik = w_k (x_ik(ξ) − y_ik),
//
// and the fit minimises S(ξ) = Σ r_i over ξ ∈ [−1, 1]ⁿ, the unknowns scaled to their ranges. The sum of
// norms, not of squares, is taken because measured impacts have outliers: a row pulls by a bounded amount.
//
// Algorithm: a coarse search along each unknown by some of the rows, then a trust-region method. d_i is
// linearised with the derivatives from displaced runs. The linear model Σ |d_i + J_i s| is minimised over the box of |s_j| ≤ Δ and the ranges, by iteratively reweighted least
// squares with the weights 1/max(|d_i + J_i s|, ε) (R. H. Byrd and D. A. Payne, Convergence of the iteratively
// reweighted least squares algorithm for robust regression, Johns Hopkins University, 1979), ε a thousandth of
// the mean residual. A step is taken if S decreases by a tenth of the predicted amount; otherwise Δ decreases
// to a quarter of the step. The fit ends when the linear model promises less than 1e-6 of S, or a step below
// 1e-4: this is 1e-6 N r̄ in S, less than a twentieth of a standard error for up to some 1000 rows N. S may have
// several minima over a wide range, which some of the rows do not distinguish. So at the first end the whole
// ranges of unknowns with a logarithmic scale (of all unknowns, if one has no influence there) are searched by
// all rows, and the fit continues from a better place.
//
// Confidence intervals are from resampling (B. Efron, Ann. Statist. 7 (1979) 1): the rows are drawn with
// replacement `resamples` times, the linear model at the optimum is minimised for each draw, and the interval
// is that of the 2.5 % and 97.5 % quantiles. They contain the scatter of the rows, whatever its distribution,
// but assume independent rows. Medians of residuals have intervals from the same kind of draws.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "study/calibration/calibrate.hpp"
#include "study/calibration/row_table.hpp"

namespace freeplay {

/// The differences d of some rows at ξ, one row each; not finite: the run failed.
using RowModel = std::function<Eigen::MatrixXd(std::span<const std::size_t> rows, const Eigen::VectorXd& xi)>;

/// Random draws of rows with replacement. Equal on all machines.
struct Resampling {
  int count = 400;
  std::uint64_t seed = 1;
  int threads = 1;  ///< for the fits to the draws; 0: all cores
};

/// Quantile p of a list in any order.
double quantile_of(std::vector<double> list, double p);

/// A fit to some rows.
struct RowFit : Optimum {
  std::vector<Estimate> unknowns;  ///< with 95 % intervals; both ends are open if it has no influence
  std::vector<double> residuals;   ///< of the fitted rows
  int iterations = 0;              ///< accepted steps
  bool settled = false;            ///< whether the search ended at a minimum
};

/// Fits unknowns to these rows. Throws std::runtime_error if a run fails at every start or beside an accepted
/// step.
RowFit fit_rows(const RowModel& model, std::span<const std::size_t> rows,
                const std::vector<Unknown>& unknowns, const Resampling& resampling);

/// One variant in one formulation: its fit to all rows (`calibrate`), or its fits without each part and the
/// predictions of these parts (`validate`).
struct RowPrediction {
  std::string variant, title, formulation;
  std::vector<Unknown> unknowns;
  std::vector<RowFit> fits;      ///< to all rows; or fit p without part p
  std::vector<double> residual;  ///< of each row, predicted; empty for a fit to all rows
  Eigen::MatrixXd difference;    ///< w_k (x_ik − y_ik) of each row, predicted
  long runs = 0;
  std::string name() const { return variant + " [" + formulation + "]"; }
};

/// Fits each variant of a study with [rows] in each of its formulations: to all rows, or with `hold_out` in
/// parts. Throws SceneError if a scene cannot be run, a run fails at the end of a fit, or a part has no rows.
std::vector<RowPrediction> predict_rows(const Study& given, const RowTable& table, bool hold_out,
                                        const Conduct& conduct, int threads,
                                        const std::function<void(const std::string&, double)>& on_progress);

/// Predicted residuals of the rows of one class.
struct RowSummary {
  std::size_t model = 0;          ///< index of the prediction
  std::string rows;               ///< class, or "all"
  std::size_t count = 0;          ///< of rows
  Estimate median;                ///< with the 95 % interval from draws of the rows
  double ninety = 0;              ///< 90 % of the residuals are below
  std::vector<double> mean = {};  ///< of each d_k: its systematic part
  bool best = false;              ///< has the least median
  /// Whether the 95 % interval of its median less that of the best model, both from the same draws,
  /// excludes 0.
  bool worse = false;
};

/// Summaries of all rows and of each class with ten rows or more, for every prediction.
std::vector<RowSummary> summaries(const Study& study, const RowTable& table,
                                  const std::vector<RowPrediction>& predictions);

}  // namespace freeplay
