// Calibration: identification of parameters (unknowns) of a scene such that statistics of its runs
// match measured ones. Outcomes are noisy, so the logarithm of each statistic is approximated by a
// response surface (study/calibration/surface.hpp), and the misfit f(ξ) of
// study/calibration/misfit.hpp is minimised over ξ ∈ [−1, 1]ⁿ, the unknowns scaled to their ranges.
//
// Algorithm:
// 1. Run the points of a space-filling design.
// 2. Evaluate what the targets can determine (Identifiability).
// 3. Refine. The surfaces guide; runs judge. Each round runs 4n + 4 more points where f is within 16
//    of its minimum, at the optimum and where the surfaces' errors are greatest, and compares each
//    outcome with its prediction. Rounds end when the predictions hold within their errors
//    (predictions_hold()) and these errors are below half of the measurement's uncertainty, or after
//    `refinements` rounds.
// 4. Fit. The ends of all intervals, the optimum and the optima without one target are run from
//    several starts, together with points as in step 3, at most `profile_rounds` times, until the
//    predictions hold there and the ends stay. Refinements continue in between as in step 3. All
//    runs belong to the surfaces. An interval is widened to every point whose own runs meet the
//    targets although the surfaces exclude it. If the last predictions do not hold, or the surfaces
//    are still not as accurate as in step 3, the fit is open (Fit::settled): it excludes nothing.
// 5. Verify the prediction of the fit by runs at its optimum and at `draws` points of its
//    likelihood.
//
// Confidence intervals are those of the profile likelihood. The 95 % interval of ξ_j consists of
// the values with
//
//     min over the other unknowns of f  ≤  min f + t²,       t = t_ν(0.975),
//
// with ν the degrees of freedom from which V is known. If this holds at a limit of the range, the
// targets do not exclude values beyond it, and the interval is open there.
//
// A point whose runs give a statistic that is not positive is an observation without a logarithm.
// Leaving it out would bias the surface, so such a fit is refused. Points whose runs failed are no
// observations; they are left out and counted. A fit has no intervals if it is inconsistent: runs
// at its optimum contradict its own targets (Fit::contradicted), or rᵀV⁻¹r exceeds the 99 %
// quantile of χ² (Fit::rejected).
//
// Use: plan_calibration(), then calibrate().
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "study/calibration/misfit.hpp"
#include "study/store/results.hpp"
#include "study/sweep/sweep.hpp"

namespace freeplay {

/// Number of runs at points of the likelihood.
inline constexpr int draws = 12;

/// Greatest number of rounds of runs at the ends of the intervals.
inline constexpr int profile_rounds = 3;

/// An estimated value with its 95 % interval.
struct Estimate {
  double value = 0, low = 0, high = 0;  ///< NaN: no interval
  /// Of an unknown: the interval does not exclude this limit of its range.
  bool open_low = false, open_high = false;
  /// No part of the range is excluded.
  bool open() const { return open_low && open_high; }
};

/// A place in the ranges with its misfit f.
struct Place {
  Eigen::VectorXd xi;
  double value = INFINITY;
};

/// What the targets determine of several unknowns that they do not determine one by one. Along a ridge
/// of the likelihood the unknown `along` passes its interval, and every other one follows it,
/// p_k ∝ p_along^powers[k] (or linearly, if a range contains values ≤ 0).
struct Ridge {
  std::size_t along = 0;
  bool powers_of = true;  ///< powers; otherwise slopes dp_k/dp_along
  std::vector<double> slope;
  /// Half of the 95 % interval of each other unknown at a given value of `along`: relative if
  /// `powers_of`, otherwise in its unit.
  std::vector<double> within;
  std::vector<bool> follows;                ///< unknowns whose interval is mainly the ridge
  std::vector<std::array<double, 2>> ends;  ///< values of all unknowns at both ends of the ridge
  /// The statistic that changes most clearly along the ridge and is no target; empty: none does.
  std::string separator;
  double change = 0;  ///< of that statistic from one end of the ridge to the other, relative
};

/// The optimum of a fit in the ranges of its unknowns.
struct Optimum {
  Eigen::VectorXd xi;
  bool at_bound(std::size_t unknown) const {
    return std::abs(xi[static_cast<Eigen::Index>(unknown)]) > 0.999;
  }
};

/// Result of a fit to some of the targets.
struct Fit : Optimum {
  std::vector<bool> used;  ///< which targets
  std::vector<Estimate> unknowns;
  std::vector<Estimate> on_surface;  ///< statistic of each target on the surface at the optimum
  std::vector<Estimate> run_again;   ///< runs at the optimum: mean and 95 % interval over starts
  /// Prediction of one more run within the uncertainty of the fit: median and 95 % interval, from
  /// runs at the draws.
  std::vector<Estimate> predictive;
  /// For each used target: whether the measured value m lies outside the 99 % range that results
  /// from the outcomes r of n runs at the optimum, the surface's error there and the measurement's
  /// tolerance,
  ///
  ///     |ln m − mean ln r| > hypot(2.58 tolerance, t √(p + 1/n) s, 2.58 s_i),
  ///
  /// with s the standard deviation of ln r, t = t_{n−1}(0.995), and p from Stretches::share, 1 if
  /// the value is given. With a single start, the leave-one-out error of the surface replaces the
  /// last two terms. A run without the statistic contradicts.
  std::vector<bool> contradicted;
  Eigen::MatrixXd draws;        ///< points ξ of the likelihood, one a row
  Eigen::MatrixXd correlation;  ///< of the unknowns, at the optimum
  double objective = 0;         ///< rᵀV⁻¹r + w|ξ|²
  double squares = 0;           ///< rᵀV⁻¹r
  int degrees = 1;              ///< of χ²: number of targets less unknowns, at least 1
  bool rejected = false;        ///< whether `squares` exceeds the 99 % quantile of χ²
  double least = 0;             ///< f at the optimum
  double level = 0;             ///< t²
  /// Points ξ at the ends of the profiles: row 2j is the lower end of unknown j, row 2j + 1 the upper one.
  Eigen::MatrixXd ends;
  /// Whether the last runs were as the surfaces predicted, and more runs would reduce no error of a surface
  /// above half of the measurement's uncertainty. If not, the fit is open: it has no intervals.
  bool settled = true;
  bool holds() const { return settled && !rejected && std::ranges::none_of(contradicted, std::identity{}); }
};

/// f − min f at two unknowns, minimised over the others.
struct MisfitPoint {
  double x = 0, y = 0, excess = 0;  ///< ξ of the two unknowns
};

/// Result of a calibration.
struct CalibrationResult {
  /// f − min f over two unknowns.
  struct Map {
    std::size_t x = 0, y = 0;         ///< unknowns
    std::vector<MisfitPoint> points;  ///< x is the outer loop
  };
  std::vector<double> measured;   ///< of the targets
  std::vector<double> tolerance;  ///< of their logarithms, as fitted
  /// Leave-one-out error of each surface of ln statistic, root mean square.
  std::vector<double> surface_error;
  std::vector<double> surface_spread;  ///< standard deviation of the outcomes of each surface
  /// For each surface: number of its points, those with a finished run.
  std::vector<int> points;
  std::optional<Ridge> ridge;  ///< of the fit to all
  int tried = 0;               ///< number of points of the design and of refinements
  int rounds = 0;              ///< number of refinements
  Identifiability before;      ///< for the space-filling design
  std::vector<Misfit::Parts>
      at_optimum;  ///< parts of each target's variance, at the optimum of the fit to all
  /// Whether each surface's error there is at most half of the measurement's uncertainty.
  bool refined = false;
  std::vector<Evidence::Outcome> outcomes;  ///< of all points
  std::vector<Map> maps;                    ///< for each pair of unknowns, of the fit to all
  Fit all;                                  ///< fit to all targets
  std::vector<Fit> left_out;                ///< fit i excludes target i; empty for a single target
  SweepSummary sweep;
  std::vector<std::string> plausibility_checks;  ///< about the units of measured files
};

/// A checked calibration, before any run or output.
struct CalibrationPlan {
  Study study;                   ///< its axes and variants are those of the space-filling design
  std::vector<Target> targets;   ///< with the sampling rates of their files
  std::vector<double> measured;  ///< of the targets
  std::vector<std::string> plausibility_checks;
  Eigen::MatrixXd points;  ///< points ξ of the design, one a row
  std::vector<PlannedRun> runs;
};

/// Plans a calibration. Throws SceneError if the study cannot be calibrated, from its file or from
/// any scene that it defines.
CalibrationPlan plan_calibration(const Study& study, const Conduct& conduct);

/// Executes missing runs into calibrate.db of the locked folder, and fits. Throws SceneError if a
/// statistic is not positive within the ranges.
CalibrationResult calibrate(CalibrationPlan plan, const Conduct& conduct, const FolderLock& lock, int threads,
                            const std::function<void(const SweepProgress&)>& on_progress);

/// The minimum of f over the used targets, and places all over the ranges, sorted by f and denser where it
/// is small.
struct Search {
  Place best;
  std::vector<Place> places;
};
/// `near`: points of runs, one a row. Throws std::runtime_error if no minimum is found.
Search search(const Misfit& misfit, const std::vector<bool>& used, const Eigen::MatrixXd& near);

/// Minimises f over the used targets, and profiles it. Throws as search().
Fit fit(const Misfit& misfit, const std::vector<bool>& used, const std::vector<Unknown>& unknowns,
        const Eigen::MatrixXd& near = {});

/// The ridge of a fit, if the interval of two or more unknowns is `ridge_ratio` times as wide as it would
/// be for known values of the others.
std::optional<Ridge> ridge_of(const Misfit& misfit, const Fit& fit, const std::vector<Unknown>& unknowns);
inline constexpr double ridge_ratio = 2.5;

/// f − min f on a grid over the ranges of two unknowns; x is the outer loop.
std::vector<MisfitPoint> misfit_map(const Misfit& misfit, const Fit& fit, Eigen::Index x, Eigen::Index y);

/// `count` points of exp(−½f/width²), one a row, from a Markov chain (Metropolis) that starts at
/// the optimum. Equal on all machines.
Eigen::MatrixXd sample(const Misfit& misfit, const Fit& fit, int count, double width = 1);

/// Whether runs at an optimum contradict the target (Fit::contradicted).
bool contradicts(const std::vector<double>& outcomes, double measured, double tolerance, double surface_error,
                 const Stretches& stretches = {});

/// Prediction interval of one more outcome: Student's, of the logarithms of positive outcomes. If
/// some are 0, the interval of the positive ones is extended to 0, and the value is the median of
/// all.
Estimate one_more(std::vector<double> outcomes);

}  // namespace freeplay
