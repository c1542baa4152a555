// ResponseSurface: approximation of a noisy statistic over scaled unknowns by universal kriging
// (Sacks, Welch, Mitchell and Wynn, Statistical Science 4 (1989) 409),
//
//     y_p = b(ξ_p)ᵀβ + z(ξ_p) + ε_p,      ξ ∈ [−1, 1]ⁿ,      Var ε_p = σ² c_p,
//     Cov(z(ξ), z(η)) = ρσ² κ(d),      d² = Σ_j (ξ_j − η_j)²/ℓ_j².
//
// b = (1, ξ_i, ξ_i ξ_j) is a quadratic trend, z a Gaussian process for deviations from it, and ε
// the noise of the outcomes. κ is exp(−½d²), or Matérn's (1 + √3 d) exp(−√3 d) (Stein,
// Interpolation of Spatial Data, 1999) where that is more likely: statistics of contacts have
// kinks where the order of events changes, and a smooth process underestimates its error there. Each ξ is
// first transformed by a warp that stretches one end of its range, with u = ½(ξ + 1):
//
//     a > 0:  u → ln(1 + a u)/ln(1 + a);     a < 0:  likewise from the other end;    a = 0:  u → u.
//
// Without the warp, outcomes that are steep in one corner would affect a surface with a single
// length scale everywhere (Snoek, Swersky, Zemel and Adams, ICML 31 (2014) 1674). Clusters of
// points do not distort the surface elsewhere.
//
// ρ, ℓ_j, a_j and κ maximise the restricted likelihood (Patterson and Thompson, Biometrika 58 (1971)
// 545; with |BᵀB|, so that trends of different warps are comparable), with lognormal priors of
// median 1: factor 2 for each ℓ_j, factor 5 for each 1 + |a_j|. ρ = 0 leaves the trend alone.
//
// The leave-one-out error is Dubrule's closed form (Mathematical Geology 15 (1983) 687),
//
//     e_p = (Qy)_p/Q_pp,      Q = K⁻¹ − K⁻¹B(BᵀK⁻¹B)⁻¹BᵀK⁻¹;
//
// for ρ = 0 it is Allen's PRESS. The variance s² of the surface (without the noise of an outcome)
// is the kriging variance s_K² of β and z. It is increased where the points nearby have large
// leave-one-out errors e_p²Q_pp/σ² (1 on average):
//
//     s²(ξ) = s_K²(ξ) max(1, h(ξ)) + (σ² − σ₀²) h(ξ),
//     h(ξ) = min(25, (1 + Σ_p k_p e_p²Q_pp/σ²)/(1 + Σ_p k_p)),      k_p = exp(−½ Σ_j (ξ_j − ξ_pj)²/(½ℓ_j)²).
//
// The second term is the roughness of the outcomes themselves: their noise beyond the variance σ₀²
// that differences between starts explain, such as jumps of a counted statistic. It affects every
// outcome at ξ and is absent if σ₀² is unknown.
#pragma once

#include <Eigen/Cholesky>
#include <vector>

namespace freeplay {

/// A fitted surface. Owns its points and the factors of K.
class ResponseSurface {
 public:
  /// Fits a surface. Rows of `points` are ξ. `noise`: relative variances c_p of the noise, empty
  /// for equal ones. `least_noise`: σ₀², a lower bound of σ²; negative: unknown. Throws std::invalid_argument
  /// unless there are at least two points more than coefficients.
  ResponseSurface(const Eigen::MatrixXd& points, const Eigen::VectorXd& outcomes,
                  const Eigen::VectorXd& noise = {}, double least_noise = -1);
  double operator()(const Eigen::VectorXd& xi) const;
  Eigen::VectorXd gradient(const Eigen::VectorXd& xi) const;
  /// Variance s² of the surface at ξ.
  double variance(const Eigen::VectorXd& xi) const { return reducible(xi) + roughness(xi); }
  /// The parts of s²: that which more runs near ξ reduce, and the roughness of the outcomes.
  double reducible(const Eigen::VectorXd& xi) const;
  double roughness(const Eigen::VectorXd& xi) const;
  /// Warps a_j.
  const Eigen::VectorXd& warps() const { return warps_; }
  /// σ²: variance of an outcome about the surface, for c = 1.
  double noise() const { return noise_; }
  /// Degrees of freedom of σ².
  double freedom() const { return freedom_; }
  int points() const { return static_cast<int>(points_.rows()); }
  /// Root mean square of the leave-one-out errors.
  double error() const { return error_; }
  /// Standard deviation of the outcomes, the error of a constant surface.
  double spread() const { return spread_; }
  static int coefficients(int unknowns) { return (unknowns + 1) * (unknowns + 2) / 2; }

 private:
  Eigen::VectorXd squares(const Eigen::VectorXd& warped) const;  // d² to each point
  double surprise_near(const Eigen::VectorXd& warped) const;     // h
  Eigen::VectorXd correlations(const Eigen::VectorXd& warped) const;
  struct Kriging;

  Eigen::MatrixXd points_;               // warped
  Eigen::VectorXd warps_;                // a_j
  Eigen::VectorXd lengths_;              // ℓ_j
  double ratio_ = 0;                     // ρ
  bool rough_ = false;                   // Matérn's κ
  Eigen::VectorXd trend_;                // β
  Eigen::VectorXd weights_;              // K⁻¹(y − Bβ)
  Eigen::MatrixXd solved_;               // K⁻¹B
  Eigen::LLT<Eigen::MatrixXd> factors_;  // of K
  Eigen::MatrixXd trend_covariance_;     // (BᵀK⁻¹B)⁻¹
  Eigen::VectorXd surprise_;             // e_p²Q_pp/σ²
  double roughness_ = 0;                 // σ² − σ₀²
  double noise_ = 0, freedom_ = 0, error_ = 0, spread_ = 0;
};

/// `count` points of Sobol's sequence in [−1, 1]ⁿ.
Eigen::MatrixXd space_filling(int unknowns, int count);

}  // namespace freeplay
