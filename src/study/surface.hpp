// A quadratic response surface,
//
//     y(ξ) = b₀ + Σ b_i ξ_i + Σ_{i≤j} b_ij ξ_i ξ_j,        ξ ∈ [−1, 1]ⁿ,
//
// fitted by least squares to a space-filling set of noisy outcomes (Box and Draper, Empirical Model-Building
// and Response Surfaces, 1987). Its error estimate is that of leaving out one point at a time, in closed form
// from the hat matrix: e_i/(1 − h_ii) (Allen's PRESS).
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace freeplay {

class ResponseSurface {
 public:
  /// Rows of `points` are ξ. Throws std::invalid_argument with fewer points than coefficients and two more.
  ResponseSurface(const Eigen::MatrixXd& points, const Eigen::VectorXd& outcomes);
  double operator()(const Eigen::VectorXd& xi) const { return basis(xi).dot(coefficients_); }
  Eigen::VectorXd gradient(const Eigen::VectorXd& xi) const;
  Eigen::MatrixXd hessian() const;
  /// Root mean square of the prediction of each point from the others.
  double error() const { return error_; }
  /// Standard deviation of the outcomes: what a surface of no use has as its error.
  double spread() const { return spread_; }
  static int coefficients(int unknowns) { return (unknowns + 1) * (unknowns + 2) / 2; }

 private:
  static Eigen::VectorXd basis(const Eigen::VectorXd& xi);
  int n_;
  Eigen::VectorXd coefficients_;
  double error_ = 0, spread_ = 0;
};

/// `count` points of Sobol's sequence in [−1, 1]ⁿ.
Eigen::MatrixXd space_filling(int unknowns, int count);

}  // namespace freeplay
