// Misfit between the model at ξ and measured statistics. With m_i the measured value and y_i the
// response surface of its logarithm,
//
//     r_i = ln m_i − y_i(ξ),     f(ξ) = rᵀV⁻¹r + ln det U + w |ξ|²,     exp(−½f): likelihood,
//     U_ij = W_ij √(p_i p_j) + δ_ij tolerance_i²,     V_ij = U_ij + ρ_ij s_i s_j.
//
// The determinant contains the uncertainty U of the measurement alone. ln det V would add
// Σ ln(1 + s_i²/U_ii), which depends on the number of runs nearby: the minimum would lie where the
// surface is well known instead of where the targets are met, and a true value between the runs would be
// excluded.
//
// W(ξ) is the covariance of one run (Scatter). The measurement is one
// realisation of it (p = 1), or the mean of q segments (Stretches::share: p = 1/q for independent
// segments, up to 1 if the motion stays in one state). s_i(ξ) is the standard error of the surface,
// with the correlations ρ of W, because the surfaces are fitted to the same runs. Statistics of
// different runs, and of different measurements, are uncorrelated. If no point has two starts, the
// noise of the surface replaces W_ii. The weak prior w = 0.1, centred in the ranges, determines
// unknowns that the targets do not.
//
// The statistics of a chaotic motion are random. Neglecting W or s gives intervals that exclude the
// true value (Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001) 425).
//
// A Misfit owns its targets with their surfaces, and the scatter of each set of runs.
#pragma once

#include <Eigen/LU>

#include <optional>
#include <string>
#include <vector>

#include "study/calibration/surface.hpp"
#include "study/settings/study.hpp"
#include "study/store/results.hpp"

namespace freeplay {

// Scatter: covariance of the statistics of a chaotic motion between starts, at any point in the
// ranges of the unknowns.
//
// At each point ξ_p some runs differ only in their start. Their relative deviations r from the mean
// at the point give
//
//     W(ξ) = Σ_p k_p Σ_s r_ps r_psᵀ / Σ_p k_p (S_p − 1),      k_p = exp(−½ Σ_j (ξ_j − ξ_pj)²/h_j²),
//     ν(ξ) = (Σ_p k_p (S_p − 1))² / Σ_p k_p² (S_p − 1),
//
// the covariance of the logarithms of one run, and its degrees of freedom. The motion may be
// regular in one part of the ranges and chaotic in another. The widths h_j are therefore those that
// best predict the deviations at each point from all other points, by the likelihood
//
//     Σ_p Σ_i −½ ((S_p − 1) ln W_ii(ξ_p) + Σ_s r_psi²/W_ii(ξ_p)),      W without point p
//
// (cross-validation: Stone, J. R. Statist. Soc. B 36 (1974) 111), initially h = ½√n. Correlations
// from few runs are exaggerated, so they are shrunk by the factor (1 − λ),
//
//     λ = Σ_{i<j} (1 − ρ_ij²)²/ν / Σ_{i<j} ρ_ij²
//
// (Schäfer and Strimmer, Stat. Appl. Genet. Mol. Biol. 4 (2005) 32).
//
// Use: add() all points, choose_widths(), then at(). Owns the sums of all points.

/// Covariance of statistics as a function of ξ.
class Scatter {
 public:
  /// Adds a point. `outcomes`: one row for each start at ξ, one column for each statistic, with
  /// positive means. A single row is ignored.
  void add(const Eigen::VectorXd& xi, const Eigen::MatrixXd& outcomes);
  /// Determines the widths h_j by cross-validation, after all points were added.
  void choose_widths();
  const Eigen::VectorXd& widths() const { return widths_; }
  /// The covariance at one ξ.
  struct Local {
    Eigen::MatrixXd covariance;  ///< of the logarithms of one run
    double freedom = 0;
  };
  Local at(const Eigen::VectorXd& xi) const;
  /// Whether any point has two starts.
  bool known() const { return !points_.empty(); }

 private:
  struct Point {
    Eigen::VectorXd xi;
    Eigen::MatrixXd squares;  // Σ_s r rᵀ
    double freedom = 0;       // S − 1
  };
  /// Cross-validation likelihood.
  double prediction(const Eigen::VectorXd& widths) const;
  std::vector<Point> points_;
  Eigen::VectorXd widths_;  // h_j
};

/// A measured statistic and its surface.
struct Observed {
  ResponseSurface surface;
  double logarithm = 0;  ///< ln m
  double tolerance = 0;  ///< relative standard uncertainty of the value
  Stretches stretches;   ///< segments, each as long as a run, whose mean is the measured value
  int runs = 0;          ///< set of runs; statistics of one set are correlated
  int column = 0;        ///< column in the scatter of these runs
  int source = 0;        ///< measurement; statistics of one measurement are correlated
};

/// Evaluates f and its parts.
class Misfit {
 public:
  static constexpr double pull = 0.1;  ///< w

  Misfit(std::vector<Observed> targets, std::vector<Scatter> scatter)
      : targets_(std::move(targets)), scatter_(std::move(scatter)) {}
  const std::vector<Observed>& targets() const { return targets_; }

  /// The misfit at one ξ.
  struct At {
    Eigen::VectorXd residual;    ///< r, of the used targets
    Eigen::MatrixXd covariance;  ///< V
    double squares = 0;          ///< rᵀV⁻¹r
    double value = 0;            ///< f
  };
  /// Outcomes of runs at one ξ, of all targets: logarithms of their means, and numbers of starts.
  struct Own {
    Eigen::VectorXd logarithms, starts;
  };
  /// `own`: replaces the surfaces and their errors, which are then √(W_ii/starts).
  At at(const Eigen::VectorXd& xi, const std::vector<bool>& used, const Own* own = nullptr) const;
  /// ∂y_i/∂ξ_j of the used targets.
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& xi, const std::vector<bool>& used) const;

  /// The parts of a target's variance V_ii.
  struct Parts {
    double scatter = 0;  ///< W_ii p_i
    double surface = 0;  ///< s_i²
    double freedom = 0;  ///< degrees of freedom of W_ii
    double run = 0;      ///< W_ii
  };
  Parts parts(std::size_t target, const Eigen::VectorXd& xi) const;
  /// Degrees of freedom from which V_ii is known, the least of the used targets (Satterthwaite).
  /// Infinite if V contains tolerances only.
  double freedom(const Eigen::VectorXd& xi, const std::vector<bool>& used) const;

 private:
  std::vector<Observed> targets_;
  std::vector<Scatter> scatter_;  // for each set of runs
};

/// Predicted outcome of a run, ln statistic, and the variance of the difference of the outcome.
struct Forecast {
  double value = 0, variance = 0;
};
/// Forecasts of the targets at one point for the mean of some starts. An error below half of the
/// measurement's uncertainty does not matter.
std::vector<Forecast> forecasts(const Misfit& misfit, const Eigen::VectorXd& xi, int starts);
/// Whether outcomes are as predicted: not more of them lie outside the 95 % intervals of their forecasts
/// than happens once in 200 rounds (binomial distribution). The intervals of the unknowns need no more;
/// errors at jumps of a statistic are not normal.
bool predictions_hold(const std::vector<Forecast>& forecasts, const std::vector<double>& outcomes);

/// Value of an unknown at ξ ∈ [−1, 1].
double unscaled(const Unknown& unknown, double xi);
/// KEY=VALUE of each unknown at ξ.
std::vector<std::string> overrides_at(const Calibration& calibration, const Eigen::VectorXd& xi);
/// A matrix with these rows; at least one.
Eigen::MatrixXd as_rows(const std::vector<Eigen::VectorXd>& rows);

/// A statistic of a run: one of TurnMetrics, or a measure of the study.
struct TargetStatistic {
  TurnMetrics::Name metric = TurnMetrics::count;  ///< count: none
  std::size_t measure = 0;
  double of(const RunRow& row) const {
    return metric == TurnMetrics::count ? row.measures.at(measure) : row.metric.at(metric);
  }
  /// A measure whose logarithm is fitted is positive.
  TurnMetrics::Kind kind() const {
    return metric == TurnMetrics::count ? TurnMetrics::Kind::positive : TurnMetrics::kind(metric);
  }
};
TargetStatistic statistic_of(const Study& study, const Target& target);

/// Name of the runs of a target. Targets with the same scene and sampling share their runs.
std::string name_of_run(const std::string& what, const Target& target);

/// All outcomes so far, and the misfit that follows from them. Refers to its arguments.
class Evidence {
 public:
  Evidence(const Study& study, const Calibration& c, const std::vector<double>& measured);

  const TargetStatistic& statistic(std::size_t target) const { return statistics_[target]; }
  void add(const std::vector<RunRow>& rows, const std::string& point, const Eigen::VectorXd& xi);
  int tried() const { return static_cast<int>(tried_.size()); }
  /// All points, one a row.
  Eigen::MatrixXd points() const { return as_rows(tried_); }
  /// Outcomes at one point; none if a run failed or a statistic is not positive there.
  std::optional<Misfit::Own> own(int point) const;
  /// Outcome of the runs at a point: the mean over its starts.
  struct Outcome {
    std::size_t target = 0;
    Eigen::VectorXd xi;
    double value = 0;
  };
  std::vector<Outcome> outcomes() const;
  /// Throws SceneError if a statistic is not positive at some point.
  Misfit misfit() const;

 private:
  /// Runs that several targets share, and their outcomes at each ξ: a row for each start, a column
  /// for each target.
  struct Runs {
    std::vector<std::size_t> targets;
    std::vector<int> point;  // numbers of the points whose runs finished
    std::vector<Eigen::VectorXd> xi;
    std::vector<Eigen::MatrixXd> outcomes;
  };
  void require_positive(const Runs& r, std::size_t column) const;
  ResponseSurface surface(const Runs& r, std::size_t column, const Scatter& scatter,
                          const Target& target) const;

  const Study& study_;
  const Calibration& c_;
  const std::vector<double>& measured_;
  std::vector<Runs> runs_;
  std::vector<TargetStatistic> statistics_;
  std::vector<Eigen::VectorXd> tried_;
};

/// What targets can determine before any fit: evaluated at the points of the design, from V without
/// the measured values.
struct Identifiability {
  /// Of each target (row) and unknown (column): root mean square of ∂y_i/∂ξ_j/√V_ii, in standard
  /// uncertainties over half the range.
  Eigen::MatrixXd sensitivity;
  /// Of each unknown: expected 95 % interval over its range, median over the points ξ_p. The interval
  /// comprises ξ_pj ± 1.96 σ_j with σ_j² = ((JᵀV⁻¹J + w)⁻¹)_jj, and all places η of a space-filling set
  /// whose statistics cannot be distinguished from those at ξ_p, (y(η) − y(ξ_p))ᵀV(η)⁻¹(y(η) − y(ξ_p)) ≤
  /// 1.96²: a curved ridge, or a second minimum, is wider than the linear part.
  std::vector<double> left_open;
  Eigen::MatrixXd correlation;  ///< of the unknowns, from the mean of JᵀV⁻¹J + w
  /// Whether the interval is expected to exclude a substantial part of the range.
  bool identified(std::size_t unknown) const { return left_open[unknown] < 0.8; }
};
/// Evaluates the identifiability over the points ξ of a design, one a row.
Identifiability identifiability(const Misfit& misfit, const Eigen::MatrixXd& points);

}  // namespace freeplay
