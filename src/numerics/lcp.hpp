// The linear complementarity problem:  w = A z + b,   0 ≤ w ⊥ z ≥ 0.
#pragma once

#include <Eigen/Core>

namespace freeplay {

struct LcpResult {
  enum class Status { solved, ray, pivots_exhausted };
  Status status = Status::solved;
  int pivots = 0;
  /// max_i |min(z_i, w_i)| with w = A z + b computed afresh, divided by max |b|.
  double residual = 0;
};

/// Lemke's complementary pivoting with lexicographic ratio test (Cottle, Pang, Stone, "The Linear
/// Complementarity Problem", 1992, section 4.4 and 4.9): it cannot cycle, and ends in a solution or on a ray.
/// Storage is made once for problems up to `max_size`; solving allocates nothing. Each solve fills what it
/// reads: nothing passes from one to the next.
class Lemke {
 public:
  explicit Lemke(int max_size);
  /// A (n × n, column-major with leading dimension `stride`), b, and the solution z of length n.
  LcpResult solve(int n, const double* A, int stride, const double* b, double* z);

 private:
  void pivot(int n, int row, int column);
  int leaving_row(int n, int column) const;

  Eigen::MatrixXd tableau_;  // columns: w (n), z (n), z0, b
  Eigen::VectorXi basis_;
  double scale_ = 0;  // of b
};

/// The residual of a proposed solution, as defined in LcpResult.
double lcp_residual(int n, const double* A, int stride, const double* b, const double* z);

}  // namespace freeplay
