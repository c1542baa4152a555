#include "numerics/dense.hpp"

#include <Eigen/Eigenvalues>

namespace freeplay {

using Eigen::MatrixXd, Eigen::VectorXd;

void DenseLu::compute(const ConstMatrix& A) { lu_.compute(A); }

void DenseLu::solve(const ConstVector& b, VectorXd& x) const { x = lu_.solve(b); }

double DenseLu::pivot_ratio() const {
  const auto pivots = lu_.matrixLU().diagonal().cwiseAbs();
  return pivots.size() > 0 ? pivots.minCoeff() / pivots.maxCoeff() : 1;
}

int DenseLu::sign() const {
  auto sign = static_cast<int>(lu_.permutationP().determinant());
  for (Eigen::Index r = 0; r < lu_.rows(); ++r) sign *= lu_.matrixLU()(r, r) < 0 ? -1 : 1;
  return sign;
}

MinimumNorm::MinimumNorm(const ConstMatrix& A, std::optional<double> threshold) {
  if (threshold) decomposition_.setThreshold(*threshold);
  decomposition_.compute(A);
}

VectorXd MinimumNorm::solve(const ConstVector& b) const { return decomposition_.solve(b); }

Eigen::Index MinimumNorm::rank() const { return decomposition_.rank(); }

std::optional<MatrixXd> solve_regular(const ConstMatrix& A, const ConstMatrix& B) {
  const Eigen::FullPivLU<MatrixXd> lu(A);
  if (!lu.isInvertible()) return std::nullopt;
  return lu.solve(B);
}

MatrixXd kernel(const ConstMatrix& A, double threshold) {
  Eigen::FullPivLU<MatrixXd> lu(A);
  lu.setThreshold(threshold);
  return lu.kernel();
}

MatrixXd orthogonal_complement(const ConstMatrix& A, double threshold) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
  qr.setThreshold(threshold);
  qr.compute(A);
  const MatrixXd Q = qr.householderQ();
  return Q.rightCols(Q.cols() - qr.rank());
}

SymmetricEigen symmetric_eigen(const ConstMatrix& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

GeneralEigen general_eigen(const ConstMatrix& A) {
  const Eigen::EigenSolver<MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace freeplay
