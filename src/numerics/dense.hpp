// Dense decompositions of matrices whose size is known at run time. Eigen's templates are instantiated in dense.cpp alone;
// systems of at most a few rows on hot paths keep matrices of fixed capacity, which take no memory, in their own files.
// Source: Golub and Van Loan, Matrix Computations, 4th ed. (2013), chapters 3, 5, 7 and 8.
#pragma once

#include <Eigen/LU>
#include <Eigen/QR>
#include <complex>
#include <optional>

namespace freeplay {

using ConstMatrix = Eigen::Ref<const Eigen::MatrixXd>;
using ConstVector = Eigen::Ref<const Eigen::VectorXd>;

/// P A = L U with partial pivoting. Keeps its memory from one matrix to the next of the same size.
class DenseLu {
 public:
  void compute(const ConstMatrix& A);
  /// x = A⁻¹ b; x is not b.
  void solve(const ConstVector& b, Eigen::VectorXd& x) const;
  /// Least pivot over the largest, in size: zero where A is singular.
  double pivot_ratio() const;
  /// Sign of the determinant of A.
  int sign() const;

 private:
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
};

/// The complete orthogonal decomposition A = Q [T 0; 0 0] Zᵀ Pᵀ. Pivots below `threshold` times the largest count as zero;
/// without one, below rounding.
class MinimumNorm {
 public:
  explicit MinimumNorm(const ConstMatrix& A, std::optional<double> threshold = {});
  /// Of all x with least |A x − b| the shortest.
  Eigen::VectorXd solve(const ConstVector& b) const;
  Eigen::Index rank() const;

 private:
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition_;
};

/// A⁻¹ B by elimination with full pivoting; nothing where A is singular.
std::optional<Eigen::MatrixXd> solve_regular(const ConstMatrix& A, const ConstMatrix& B);

/// Columns that span {x: A x = 0}, by elimination with full pivoting; one column of zeros where there is none but zero.
Eigen::MatrixXd kernel(const ConstMatrix& A, double threshold);

/// Orthonormal columns that span what is orthogonal to the columns of A.
Eigen::MatrixXd orthogonal_complement(const ConstMatrix& A, double threshold);

struct SymmetricEigen {
  Eigen::VectorXd values;  ///< ascending
  Eigen::MatrixXd vectors;
};
/// Of a symmetric A, of which the lower triangle is read.
SymmetricEigen symmetric_eigen(const ConstMatrix& A);

struct GeneralEigen {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};
GeneralEigen general_eigen(const ConstMatrix& A);

}  // namespace freeplay
