// How much a chaotic motion's statistics scatter from start to start, and with each other, anywhere in the ranges of unknowns.
//
// At each point ξ_p some runs differ in their start alone. Their relative deviations r from the mean of the point give
//
//     W(ξ) = Σ_p k_p Σ_s r_ps r_psᵀ / Σ_p k_p (S_p − 1),      k_p = exp(−|ξ − ξ_p|²/2h²),   h = ½√n,
//     ν(ξ) = (Σ_p k_p (S_p − 1))² / Σ_p k_p² (S_p − 1),
//
// a covariance of logarithms of one run, and the degrees of freedom that it is known from. A few runs exaggerate correlations: they
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
  std::vector<Point> points_;
};

}  // namespace freeplay
