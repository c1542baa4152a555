// The linear complementarity problem  w = A z + b,   0 ≤ w ⊥ z ≥ 0.  formulations/contact/solvers.cpp
// writes contact problems in this form.
#pragma once

#include <Eigen/Core>

namespace freeplay {

struct LcpResult {
  enum class Status { solved, ray, pivots_exhausted };
  Status status = Status::solved;
  int pivots = 0;
  /// max_i |min(z_i, w_i)| divided by max |b|, with w = A z + b computed from z.
  double residual = 0;
};

/// Lemke's complementary pivoting with lexicographic ratio test (Cottle, Pang, Stone, "The Linear
/// Complementarity Problem", 1992, sections 4.4 and 4.9). It cannot cycle; it ends in a solution or
/// on a ray. Storage for problems up to `max_size` is allocated once; solve() does not allocate. No
/// state passes from one solve to the next.
class Lemke {
 public:
  explicit Lemke(int max_size);
  /// Solves for z (n entries). A is n × n, column-major with leading dimension `stride`.
  LcpResult solve(int n, const double* A, int stride, const double* b, double* z);

 private:
  void pivot(int n, int row, int column);
  int leaving_row(int n, int column) const;

  Eigen::MatrixXd tableau_;  // columns: w (n), z (n), z0, b
  Eigen::VectorXi basis_;
  double scale_ = 0;  // scale of b
};

/// The residual of a given z, as defined in LcpResult.
double lcp_residual(int n, const double* A, int stride, const double* b, const double* z);

// Small least-squares problems with inequalities (Lawson and Hanson, Solving Least Squares
// Problems, 1974, chapter 23).

/// Minimises |K x − y| over x ≥ 0. The caller scales the columns of K. A column whose gradient is
/// at most `none` is not added to the active set.
void nonnegative_least_squares(const Eigen::MatrixXd& K, const Eigen::VectorXd& y, Eigen::VectorXd& x,
                               double none);

/// The shortest x with G x ≥ h (least distance programming, by the dual nonnegative least squares).
/// Returns false if there is none. G and h must be of unit size and the least length below about
/// 1e4. The inequalities may be violated by `slack` if rounding makes them infeasible.
bool least_distance(const Eigen::MatrixXd& G, const Eigen::VectorXd& h, double slack, Eigen::VectorXd& x);

}  // namespace freeplay
