// How far a model at ξ is from measured statistics. With m_i measured and y_i the response surface of the logarithm,
//
//     r_i = ln m_i − y_i(ξ),     f(ξ) = rᵀV⁻¹r + ln det V + w |ξ|²,     exp(−½f): likelihood,
//     V_ij = W_ij √(p_i p_j) + ρ_ij s_i s_j + δ_ij tolerance_i²:
//
// W(ξ) is the scatter of one run (study/calibration/scatter.hpp), of which the measurement is one realisation (p = 1), or the mean of q
// stretches (Stretches::share: p = 1/q where these are independent, up to 1 where the motion keeps to one state); s_i(ξ) is the
// surface's own standard error there, correlated as the runs that it is fitted to (ρ of W); statistics of other runs, and of other
// measurements, do not correlate. Without two starts anywhere the surface's noise stands for W_ii. The weak pull w = 0.1 to the
// middle of the ranges decides what the targets leave open.
//
// A chaotic motion's statistic is a random number: leaving out W or s makes intervals that exclude the truth (Kennedy and O'Hagan,
// J. R. Statist. Soc. B 63 (2001) 425).
#pragma once

#include <vector>

#include "study/calibration/scatter.hpp"
#include "study/calibration/surface.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

/// A measured statistic and its surface.
struct Observed {
  ResponseSurface surface;
  double logarithm = 0;  ///< ln m
  double tolerance = 0;  ///< relative standard uncertainty of the value
  Stretches stretches;   ///< as long as a run, that the measured value is the mean of
  int runs = 0;          ///< which runs it is taken from: those that share a number correlate
  int column = 0;        ///< of the runs' scatter
  int source = 0;        ///< which measurement: those that share a number correlate
};

class Misfit {
 public:
  static constexpr double pull = 0.1;  ///< w

  Misfit(std::vector<Observed> targets, std::vector<Scatter> scatter)
      : targets_(std::move(targets)), scatter_(std::move(scatter)) {}
  const std::vector<Observed>& targets() const { return targets_; }

  struct At {
    Eigen::VectorXd residual;    ///< r, of the used targets
    Eigen::MatrixXd covariance;  ///< V
    double squares = 0;          ///< rᵀV⁻¹r
    double value = 0;            ///< f
  };
  At at(const Eigen::VectorXd& xi, const std::vector<bool>& used) const;
  /// ∂y_i/∂ξ_j of the used targets.
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& xi, const std::vector<bool>& used) const;

  /// What a target's V_ii is made of.
  struct Parts {
    double scatter = 0;  ///< W_ii p_i
    double surface = 0;  ///< s_i²
    double freedom = 0;  ///< that W_ii is known from
  };
  Parts parts(std::size_t target, const Eigen::VectorXd& xi) const;
  /// Degrees of freedom that V_ii are known from, the fewest of the used targets (Satterthwaite); infinite where
  /// tolerances are all there is.
  double freedom(const Eigen::VectorXd& xi, const std::vector<bool>& used) const;

 private:
  std::vector<Observed> targets_;
  std::vector<Scatter> scatter_;  // of each set of runs
};

/// What targets can say of unknowns, before any is fitted: over the points of the set, by V without the measured values.
struct Identifiability {
  /// Of each target (row) and unknown (column): root mean square of ∂y_i/∂ξ_j/√V_ii, standard uncertainties over half the range.
  Eigen::MatrixXd sensitivity;
  /// Of each unknown: 95 % interval to expect over its range, median over the points, at most 1: min(1, 1.96 σ_j),
  /// σ² = ((JᵀV⁻¹J + w)⁻¹)_jj.
  std::vector<double> left_open;
  Eigen::MatrixXd correlation;  ///< of the unknowns, by the mean of JᵀV⁻¹J + w
  /// Most of its range would be left.
  bool identified(std::size_t unknown) const { return left_open[unknown] < 0.8; }
};
Identifiability identifiability(const Misfit& misfit, const Eigen::MatrixXd& points);

}  // namespace freeplay
