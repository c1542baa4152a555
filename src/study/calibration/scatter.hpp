// How much a chaotic motion's statistics scatter from start to start, and with each other, anywhere in the ranges of unknowns.
//
// At each point ξ_p some runs differ in their start alone. Their relative deviations r from the mean of the point give
//
//     W(ξ) = Σ_p k_p Σ_s r_ps r_psᵀ / Σ_p k_p (S_p − 1),      k_p = exp(−½ Σ_j (ξ_j − ξ_pj)²/h_j²),
//     ν(ξ) = (Σ_p k_p (S_p − 1))² / Σ_p k_p² (S_p − 1),
//
// a covariance of logarithms of one run, and the degrees of freedom that it is known from. Motion may be
// regular in one part of the ranges and chaotic in another: h_j are those that predict each point's deviations
// best from all other points, by the likelihood
//
//     Σ_p Σ_i −½ ((S_p − 1) ln W_ii(ξ_p) + Σ_s r_psi²/W_ii(ξ_p)),      W without point p
//
// (cross-validation: Stone, J. R. Statist. Soc. B 36 (1974) 111), h = ½√n before. A few runs exaggerate correlations: they
// are shrunk by (1 − λ), λ = Σ_{i<j} (1 − ρ_ij²)²/ν / Σ_{i<j} ρ_ij² (Schäfer and Strimmer, Stat. Appl. Genet. Mol. Biol. 4
// (2005) 32).
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace freeplay {

class Scatter {
 public:
  /// `outcomes`: of the starts at ξ, a row each, a column for each statistic; positive means. One row says nothing.
  void add(const Eigen::VectorXd& xi, const Eigen::MatrixXd& outcomes);
  /// Chooses the widths h_j from the points, once all are added.
  void choose_widths();
  const Eigen::VectorXd& widths() const { return widths_; }
  struct Local {
    Eigen::MatrixXd covariance;  ///< of logarithms, of one run
    double freedom = 0;
  };
  Local at(const Eigen::VectorXd& xi) const;
  /// Whether any point had two starts.
  bool known() const { return !points_.empty(); }

 private:
  struct Point {
    Eigen::VectorXd xi;
    Eigen::MatrixXd squares;  // Σ_s r rᵀ
    double freedom = 0;       // S − 1
  };
  /// Likelihood of each point by the others.
  double prediction(const Eigen::VectorXd& widths) const;
  std::vector<Point> points_;
  Eigen::VectorXd widths_;  // h_j
};

}  // namespace freeplay
