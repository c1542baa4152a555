// Dense decompositions of matrices whose size is known at run time. Only dense.cpp instantiates
// Eigen's templates for them. Systems of a few rows on hot paths use matrices of fixed capacity,
// which do not allocate, in their own files. Source: Golub and Van Loan, Matrix Computations, 4th
// ed. (2013), chapters 3, 5, 7 and 8.
#pragma once

#include <Eigen/LU>
#include <Eigen/QR>
#include <array>
#include <complex>
#include <optional>

namespace freeplay {

using ConstMatrix = Eigen::Ref<const Eigen::MatrixXd>;
using ConstVector = Eigen::Ref<const Eigen::VectorXd>;

/// P A = L U with partial pivoting. Up to six rows it allocates nothing; the operations and their
/// order are those of Eigen's decomposition. Reuses its memory for larger matrices of the same size.
class DenseLu {
 public:
  void compute(const ConstMatrix& A);
  /// x = A⁻¹ b; x and b must be different vectors.
  void solve(const ConstVector& b, Eigen::VectorXd& x) const;
  /// Ratio of the least to the greatest pivot in absolute value; zero if A is singular.
  double pivot_ratio() const;
  /// Sign of the determinant of A.
  int sign() const;

 private:
  static constexpr int most_small = 6;
  int small_ = 0;                                  // rows; 0: lu_ is in force
  std::array<double, most_small * most_small> f_;  // factors by columns
  std::array<int, most_small> swap_;               // row exchanged with row k
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
};

/// A⁻¹ B column by column.
inline Eigen::MatrixXd solve_columns(const DenseLu& A, const ConstMatrix& B) {
  Eigen::MatrixXd X(B.rows(), B.cols());
  Eigen::VectorXd x(B.rows());
  for (Eigen::Index j = 0; j < B.cols(); ++j) {
    A.solve(B.col(j), x);
    X.col(j) = x;
  }
  return X;
}

/// The complete orthogonal decomposition A = Q [T 0; 0 0] Zᵀ Pᵀ. Pivots below `threshold` times the
/// greatest one count as zero; without a threshold, those below rounding.
class MinimumNorm {
 public:
  explicit MinimumNorm(const ConstMatrix& A, std::optional<double> threshold = {});
  /// The shortest x among those with least |A x − b|.
  Eigen::VectorXd solve(const ConstVector& b) const;
  Eigen::Index rank() const;

 private:
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition_;
};

/// A⁻¹ B by elimination with full pivoting; empty if A is singular.
std::optional<Eigen::MatrixXd> solve_regular(const ConstMatrix& A, const ConstMatrix& B);

/// A basis of {x: A x = 0} in columns, by elimination with full pivoting; one column of zeros if A
/// is regular.
Eigen::MatrixXd kernel(const ConstMatrix& A, double threshold);

/// An orthonormal basis, in columns, of the orthogonal complement of A's columns.
Eigen::MatrixXd orthogonal_complement(const ConstMatrix& A, double threshold);
/// The same for independent columns. It is a continuous function of A.
Eigen::MatrixXd orthogonal_complement(const ConstMatrix& A);

struct SymmetricEigen {
  Eigen::VectorXd values;  ///< ascending
  Eigen::MatrixXd vectors;
};
/// Eigenvalues and eigenvectors of a symmetric A; only its lower triangle is read.
SymmetricEigen symmetric_eigen(const ConstMatrix& A);

struct GeneralEigen {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};
GeneralEigen general_eigen(const ConstMatrix& A);

}  // namespace freeplay
