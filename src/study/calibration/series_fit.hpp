// Calibration to measured time series. A target names a column of a run and a file with the measured
// samples; the residual at each sample is the column, linear between its rows, less the measured value.
// The unknowns minimise the squares of the residuals of all targets without `hold_out`, each divided by
// the standard deviation of its measured values; their intervals allow for the autocorrelation of the
// residuals (study/calibration/series_estimate.hpp). Then all targets, fitted or held out, are run in each
// formulation of the study, and their misfits are reported, in the unit of the channel and, at the flanks
// of a loop, in that of the column `against`.
//
// A column of means (fx_mean) is the mean over the time since the previous row; it holds at the middle of
// that time. Nothing is shifted, scaled or offset.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "study/calibration/calibrate.hpp"

namespace freeplay {

/// Misfit of one series.
struct SeriesMisfit {
  std::size_t samples = 0;
  double rms = 0;               ///< of the residual, in the unit of the channel
  double mean = 0;              ///< of the residual
  double greatest = 0;          ///< residual of the greatest magnitude, with its sign
  double greatest_at = 0;       ///< s
  double measured_rms = 0;      ///< of the measured values about their mean
  double correlation_time = 0;  ///< s, τ times the mean distance of samples
  double independent = 0;       ///< samples over τ
  /// @name Flanks, if the target has levels
  /// A flank passes a level where |value| first reaches it after a change of sign. Model and measurement
  /// are compared where both pass a level with the same sign, nearest in time.
  ///@{
  std::size_t flanks = 0;    ///< compared passages
  std::size_t unpaired = 0;  ///< of either, without a partner
  double flank_rms = 0;      ///< of the difference of `against`, in its unit
  /// Mean of the difference in the direction of the value: > 0 where the model reaches a level later.
  double flank_mean = 0;
  ///@}
};

/// A target in one formulation, at the optimum.
struct ComparedSeries {
  std::size_t target = 0;
  std::string formulation;
  bool fitted = false;          ///< whether this series in this formulation determined the unknowns
  std::vector<double> t;        ///< s
  std::vector<double> against;  ///< empty without that column
  std::vector<double> measured, model;
  SeriesMisfit misfit;
  std::string reason;  ///< why the run stopped; empty: it did not
};

/// Result of a calibration to series.
struct SeriesFit : Optimum {
  std::vector<Estimate> unknowns;  ///< 95 % intervals; NaN: too few independent samples
  Eigen::MatrixXd correlation;     ///< of the unknowns
  double independent = 0;          ///< samples of the fitted series, over τ
  bool converged = false;
  int runs = 0, iterations = 0;
  std::vector<ComparedSeries> series;  ///< each target in each formulation
  /// The fit converged, determines every unknown, and all runs at the optimum finished.
  bool holds() const {
    return converged && std::ranges::none_of(unknowns, &Estimate::open) &&
           std::ranges::all_of(series, &std::string::empty, &ComparedSeries::reason);
  }
};

/// Whether the targets are series. A study has no other targets then.
bool fits_series(const Calibration& calibration);

/// Statistics of a comparison of series of equal length. `levels`: of the target.
SeriesMisfit misfit_of(const std::vector<double>& t, const std::vector<double>& against,
                       const std::vector<double>& measured, const std::vector<double>& model,
                       const std::vector<double>& levels);

/// Fits the unknowns of such a study; runs in parallel on `threads` threads (0: all cores). `on_run` gets
/// the number of runs. Throws SceneError for a file or channel that cannot be read, std::runtime_error if
/// no run succeeds, Interrupted after a stop request.
SeriesFit fit_series(const Study& study, int threads, const StopToken& stop,
                     const std::function<void(int)>& on_run = {});

}  // namespace freeplay
