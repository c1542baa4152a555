// Calibration: unknowns of a scene such that statistics of its runs meet measured ones. Outcomes are noisy, so each logarithm of
// a statistic is replaced by a response surface (study/calibration/surface.hpp), and the misfit f(ξ) of study/calibration/misfit.hpp is minimised over
// ξ ∈ [−1, 1]ⁿ, the unknowns scaled to their ranges.
//
// In order: the space-filling set is run; what the targets can say of the unknowns is judged (Identifiability); then, as long as a
// surface's own error at the optimum exceeds half of what the measurement is known to, and at most `refinements` times, 2n + 2
// points are run, the optimum and others of exp(−½f/2²), and the surfaces are made anew of all points: twice as wide as the
// likelihood exp(−½f), so that a surface that is wrong beyond the interval's ends, and excludes the truth there, is found out.
//
// Intervals are of the profile likelihood: ξ_j belongs to the interval of 95 % where
//
//     min over the other unknowns of f  ≤  min f + t²,       t = t_ν(0.975),
//
// ν being the degrees of freedom that V is known from. Where that holds at a limit of the range, the targets do not exclude what
// lies beyond: the interval is open there. What a fit predicts is run: at its optimum, and at `draws` points of its likelihood.
//
// A point whose runs give no positive statistic is an observation without a logarithm: left out, it would bend the
// surface towards what was met. Such a fit is refused. Points whose runs failed are no observations; they are left out
// and counted. And a fit has no intervals that does not hold: one whose own targets runs at its optimum contradict
// (Fit::contradicted), or whose rᵀV⁻¹r is beyond 99 % of χ² (Fit::rejected).
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <vector>

#include "study/calibration/misfit.hpp"
#include "study/store/results.hpp"
#include "study/sweep/sweep.hpp"

namespace freeplay {

inline constexpr int draws = 12;

struct Estimate {
  double value = 0, low = 0, high = 0;       ///< 95 %; NaN: none
  bool open_low = false, open_high = false;  ///< of an unknown: the limit of its range is not excluded
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
  /// Of the targets fitted to: whether the measured value lies outside 99 % of what runs at the optimum, the surface's error there
  /// and its own tolerance allow together, |ln m − mean ln r| > hypot(2.58 tolerance, t √(p + 1/n) s, 2.58 s_i) over the n
  /// starts, p being Stretches::share (1 where the value is given); with a single start the error of
  /// leaving out one point stands for both. A run without the statistic contradicts.
  std::vector<bool> contradicted;
  Eigen::MatrixXd draws;        ///< ξ of the likelihood, a row each
  Eigen::MatrixXd correlation;  ///< of the unknowns, at the optimum
  double objective = 0;         ///< rᵀV⁻¹r + w|ξ|²
  double squares = 0;           ///< rᵀV⁻¹r
  int degrees = 1;              ///< of χ²: targets less unknowns, at least 1
  bool rejected = false;        ///< squares are beyond 99 % of χ²
  double least = 0;             ///< f at the optimum
  bool holds() const { return !rejected && std::ranges::none_of(contradicted, std::identity{}); }
  bool at_bound(std::size_t unknown) const {
    return std::abs(xi[static_cast<Eigen::Index>(unknown)]) > 0.999;
  }
};

/// f − min f at two unknowns, the others at their best.
struct MisfitPoint {
  double x = 0, y = 0, excess = 0;  ///< ξ of the two
};

struct CalibrationResult {
  /// What runs at a point gave: the mean over its starts.
  struct Outcome {
    std::size_t target = 0;
    Eigen::VectorXd xi;
    double value = 0;
  };
  struct Map {
    std::size_t x = 0, y = 0;         ///< unknowns
    std::vector<MisfitPoint> points;  ///< x grows last
  };
  std::vector<double> measured;       ///< of the targets
  std::vector<double> surface_error;  ///< of ln statistic, and the spread that it explains
  std::vector<double> surface_spread;
  std::vector<int> points;  ///< that each surface is fitted to: those whose runs did not all fail
  int tried = 0;            ///< points, of the set and of refinements
  int rounds = 0;           ///< of refinement
  Identifiability before;   ///< of the space-filling set
  std::vector<Misfit::Parts>
      at_optimum;        ///< of each target: what its uncertainty is made of, where the fit to all is
  bool refined = false;  ///< every surface's error there is at most half of what the measurement is known to
  std::vector<Outcome> outcomes;  ///< of every point
  std::vector<Map> maps;          ///< of each two unknowns, by the fit to all
  Fit all;                        ///< fitted to every target
  std::vector<Fit> left_out;      ///< the i-th without target i; empty with one target
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

/// Minimises f over the used targets. Throws std::runtime_error where it finds no minimum.
Fit fit(const Misfit& misfit, const std::vector<bool>& used, const std::vector<Unknown>& unknowns);

/// On a grid over the ranges, row by row of x.
std::vector<MisfitPoint> misfit_map(const Misfit& misfit, const Fit& fit, Eigen::Index x, Eigen::Index y);

/// `count` points of exp(−½f/width²), a row each: of a Markov chain (Metropolis) from the optimum, equal on every machine.
Eigen::MatrixXd sample(const Misfit& misfit, const Fit& fit, int count, double width = 1);

/// Whether runs at an optimum contradict what it was fitted to (Fit::contradicted).
bool contradicts(const std::vector<double>& outcomes, double measured, double tolerance, double surface_error,
                 const Stretches& stretches = {});

/// Where one more outcome lies: of positive ones Student's prediction interval of their logarithms; where some are 0 the
/// interval of the positive ones from 0 on, about the median of all.
Estimate one_more(std::vector<double> outcomes);

/// The value of an unknown at ξ ∈ [−1, 1].
double unscaled(const Unknown& unknown, double xi);

}  // namespace freeplay
