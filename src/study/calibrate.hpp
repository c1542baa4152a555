// Calibration: unknowns of a scene such that statistics of its runs meet measured ones. Outcomes are noisy,
// so each logarithm of a statistic is replaced by a response surface y_i(ξ), and Ipopt minimises on those
//
//     f(ξ) = Σ_i (y_i(ξ) − ln m_i)²/s_i² + w |ξ|²,       ξ ∈ [−1, 1]ⁿ,      s_i² = tolerance_i² + error_i²,
//
// with ξ the unknowns scaled to their ranges and error_i the surface's own. The weak pull w = 0.1 to the
// middle of the ranges decides what the targets leave open; without targets every ξ is 0 ± √(1/w) of its half
// range, clipped to it. Intervals are Laplace's: the inverse of half the Hessian of f. What a fit predicts is
// run: at its optimum, and at `draws` points of Laplace's normal distribution within the ranges.
//
// A point whose runs give no positive statistic is an observation without a logarithm: left out, it would bend the
// surface towards what was met. Such a fit is refused. Points whose runs failed are no observations; they are left out
// and counted. And the runs at the optimum have the last word: a fit whose own targets they contradict is said to be
// contradicted (Fit::contradicted).
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "study/results.hpp"
#include "study/surface.hpp"
#include "study/sweep.hpp"

namespace freeplay {

inline constexpr int draws = 12;

struct Estimate {
  double value = 0, low = 0, high = 0;  ///< 95 %, within the unknown's range
};

/// A fit to some of the targets.
struct Fit {
  std::vector<bool> used;  ///< of the targets
  Eigen::VectorXd xi;
  std::vector<Estimate> unknowns;
  std::vector<Estimate> on_surface;  ///< every target's statistic, by the surface at the optimum
  std::vector<Estimate> run_again;   ///< by runs at the optimum: mean and 95 % interval over starts
  /// Where one more run from the fit's own uncertainty lies: median and 95 % interval, by runs at the draws.
  std::vector<Estimate> predictive;
  /// Of the targets fitted to: whether the measured value lies outside 99 % of one more run at the optimum and of its own
  /// tolerance together, |ln m − mean ln r| > hypot(2.58 tolerance, t √(1 + 1/n) s) over the n starts; with a single start
  /// the surface's error stands for s. A run without the statistic contradicts.
  std::vector<bool> contradicted;
  Eigen::MatrixXd draws;  ///< ξ, a row each
  double objective = 0;
  bool at_bound(std::size_t unknown) const {
    return std::abs(xi[static_cast<Eigen::Index>(unknown)]) > 0.999;
  }
};

struct CalibrationResult {
  std::vector<double> measured;       ///< of the targets
  std::vector<double> surface_error;  ///< of ln statistic, and the spread that it explains
  std::vector<double> surface_spread;
  std::vector<int> points;    ///< that each surface is fitted to: those whose runs did not all fail
  Fit all;                    ///< fitted to every target
  std::vector<Fit> left_out;  ///< the i-th without target i; empty with one target
  SweepSummary sweep;
  std::vector<std::string> questions;  ///< about the units of measured files
};

/// A calibration that has been checked: nothing has been run or written for it.
struct CalibrationPlan {
  Study study;                   ///< its axes and variants are those of the space-filling set
  std::vector<Target> targets;   ///< with the sampling of their files
  std::vector<double> measured;  ///< of the targets
  std::vector<std::string> questions;
  Eigen::MatrixXd points;  ///< ξ of the set, a row each
  std::vector<PlannedRun> runs;
};

/// Throws SceneError for a study that cannot be calibrated, from its file or from any scene that it makes.
CalibrationPlan plan_calibration(const Study& study, const Conduct& conduct);

/// Runs what is missing into calibrate.db of the locked folder and fits. Throws SceneError where a statistic is not positive
/// within the ranges.
CalibrationResult calibrate(CalibrationPlan plan, const Conduct& conduct, const FolderLock& lock, int threads,
                            const std::function<void(const SweepProgress&)>& on_progress);

/// Minimises f on the surfaces of the used targets. Exposed for tests.
Fit fit(const std::vector<ResponseSurface>& surfaces, const std::vector<double>& log_measured,
        const std::vector<double>& tolerance, const std::vector<bool>& used,
        const std::vector<Unknown>& unknowns);

/// Whether runs at an optimum contradict what it was fitted to (Fit::contradicted).
bool contradicts(const std::vector<double>& outcomes, double measured, double tolerance,
                 double surface_error);

/// Where one more outcome lies: of positive ones Student's prediction interval of their logarithms; where some are 0 the
/// interval of the positive ones from 0 on, about the median of all.
Estimate one_more(std::vector<double> outcomes);

/// The value of an unknown at ξ ∈ [−1, 1].
double unscaled(const Unknown& unknown, double xi);

}  // namespace freeplay
