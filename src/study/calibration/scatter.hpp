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
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace freeplay {

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

}  // namespace freeplay
