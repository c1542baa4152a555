#include "numerics/dense.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace freeplay {

using Eigen::MatrixXd, Eigen::VectorXd;

void DenseLu::compute(const ConstMatrix& A) {
  const auto n = static_cast<int>(A.rows());
  small_ = n <= most_small ? n : 0;
  if (small_ == 0) return void(lu_.compute(A));
  const auto f = [&](int i, int j) -> double& { return f_[static_cast<std::size_t>(i + j * n)]; };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) f(i, j) = A(i, j);
  for (int k = 0; k < n; ++k) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(f(i, k)) > std::abs(f(pivot, k))) pivot = i;
    swap_[static_cast<std::size_t>(k)] = pivot;
    if (f(pivot, k) == 0) continue;
    if (pivot != k)
      for (int j = 0; j < n; ++j) std::swap(f(k, j), f(pivot, j));
    for (int i = k + 1; i < n; ++i) f(i, k) /= f(k, k);
    for (int j = k + 1; j < n; ++j)
      for (int i = k + 1; i < n; ++i) f(i, j) -= f(i, k) * f(k, j);
  }
}

void DenseLu::solve(const ConstVector& b, VectorXd& x) const {
  if (small_ == 0) {
    x = lu_.solve(b);
    return;
  }
  const int n = small_;
  const auto f = [&](int i, int j) { return f_[static_cast<std::size_t>(i + j * n)]; };
  x.resize(n);
  for (int i = 0; i < n; ++i) x[i] = b[i];
  for (int k = 0; k < n; ++k) std::swap(x[k], x[swap_[static_cast<std::size_t>(k)]]);
  for (int j = 0; j < n; ++j)
    for (int i = j + 1; i < n; ++i) x[i] -= x[j] * f(i, j);
  for (int j = n - 1; j >= 0; --j) {
    x[j] /= f(j, j);
    for (int i = 0; i < j; ++i) x[i] -= x[j] * f(i, j);
  }
}

double DenseLu::pivot_ratio() const {
  if (small_ > 0) {
    double least = std::abs(f_[0]), most = least;
    for (int k = 1; k < small_; ++k) {
      const double pivot = std::abs(f_[static_cast<std::size_t>(k + k * small_)]);
      least = std::min(least, pivot);
      most = std::max(most, pivot);
    }
    return least / most;
  }
  const auto pivots = lu_.matrixLU().diagonal().cwiseAbs();
  return pivots.size() > 0 ? pivots.minCoeff() / pivots.maxCoeff() : 1;
}

int DenseLu::sign() const {
  if (small_ > 0) {
    int sign = 1;
    for (int k = 0; k < small_; ++k) {
      if (swap_[static_cast<std::size_t>(k)] != k) sign = -sign;
      if (f_[static_cast<std::size_t>(k + k * small_)] < 0) sign = -sign;
    }
    return sign;
  }
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

MatrixXd orthogonal_complement(const ConstMatrix& A) {
  const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(A).householderQ();
  return Q.rightCols(A.rows() - A.cols());
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
