// A response surface of a noisy statistic over scaled unknowns,
//
//     y_p = b(ξ_p)ᵀβ + z(ξ_p) + ε_p,      ξ ∈ [−1, 1]ⁿ,      Var ε_p = σ² c_p,
//     Cov(z(ξ), z(η)) = ρσ² exp(−½ Σ_j (ξ_j − η_j)²/ℓ_j²):
//
// with ξ behind a warp of each unknown that widens one end of its range, u = ½(ξ + 1):
//
//     a > 0:  u → ln(1 + a u)/ln(1 + a);     a < 0:  the same from the other end;     a = 0:  u → u,
//
// b = (1, ξ_i, ξ_i ξ_j) is a quadratic trend, z a Gaussian process for what no quadratic follows, and ε the
// noise of the outcomes (universal kriging: Sacks, Welch, Mitchell and Wynn, Statistical Science 4 (1989) 409).
// ρ, ℓ_j and a_j are those of the greatest restricted likelihood (Patterson and Thompson, Biometrika 58 (1971)
// 545; with |BᵀB|, so that trends of different warps compare), with lognormal priors of median 1 and factor 2
// on each ℓ_j, and of factor 5 on each 1 + |a_j|; ρ = 0 is the trend alone. Without a warp, outcomes that are
// steep in a corner alone bend a surface of one length everywhere (Snoek, Swersky, Zemel and Adams, ICML 31
// (2014) 1674). Points may crowd where they are needed: none bends the surface elsewhere.
//
// The error of predicting each point from all others is Dubrule's closed form, e_p = (Qy)_p/Q_pp with
// Q = K⁻¹ − K⁻¹B(BᵀK⁻¹B)⁻¹BᵀK⁻¹ (Mathematical Geology 15 (1983) 687); with ρ = 0 it is Allen's PRESS. The
// prediction's variance s² (of the surface, without the noise of one outcome) is that of β and z, s_K². Where
// the points around are predicted worse, by their e_p²Q_pp/σ² (1 in the mean), it is as many times greater:
//
//     s²(ξ) = s_K²(ξ) max(1, (1 + Σ_p k_p e_p²Q_pp/σ²)/(1 + Σ_p k_p)),
//     k_p = exp(−½ Σ_j (ξ_j − ξ_pj)²/(½ℓ_j)²).
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace freeplay {

class ResponseSurface {
 public:
  /// Rows of `points` are ξ; `noise`: c_p, the noise's relative variances, empty for equal ones; `least_noise`: what σ² is
  /// known not to be less than. Throws std::invalid_argument with fewer points than coefficients and two more.
  ResponseSurface(const Eigen::MatrixXd& points, const Eigen::VectorXd& outcomes,
                  const Eigen::VectorXd& noise = {}, double least_noise = 0);
  double operator()(const Eigen::VectorXd& xi) const;
  Eigen::VectorXd gradient(const Eigen::VectorXd& xi) const;
  /// Of the surface at ξ.
  double variance(const Eigen::VectorXd& xi) const;
  /// a_j.
  const Eigen::VectorXd& warps() const { return warps_; }
  /// σ²: of an outcome about the surface, where c = 1.
  double noise() const { return noise_; }
  /// Degrees of freedom that σ² is known from.
  double freedom() const { return freedom_; }
  /// Root mean square of the prediction of each point from the others.
  double error() const { return error_; }
  /// Standard deviation of the outcomes: what a surface of no use has as its error.
  double spread() const { return spread_; }
  static int coefficients(int unknowns) { return (unknowns + 1) * (unknowns + 2) / 2; }

 private:
  Eigen::VectorXd correlations(const Eigen::VectorXd& warped, double share = 1) const;  // by share·ℓ
  struct Kriging;

  Eigen::MatrixXd points_;            // warped
  Eigen::VectorXd warps_;             // a_j
  Eigen::VectorXd lengths_;           // ℓ_j
  double ratio_ = 0;                  // ρ
  Eigen::VectorXd trend_;             // β
  Eigen::VectorXd weights_;           // K⁻¹(y − Bβ)
  Eigen::MatrixXd solved_;            // K⁻¹B
  Eigen::MatrixXd inverse_;           // K⁻¹
  Eigen::MatrixXd trend_covariance_;  // (BᵀK⁻¹B)⁻¹
  Eigen::VectorXd surprise_;          // e_p²Q_pp/σ²
  double noise_ = 0, freedom_ = 0, error_ = 0, spread_ = 0;
};

/// `count` points of Sobol's sequence in [−1, 1]ⁿ.
Eigen::MatrixXd space_filling(int unknowns, int count);

}  // namespace freeplay
