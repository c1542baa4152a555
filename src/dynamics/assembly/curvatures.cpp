#include "dynamics/assembly/curvatures.hpp"

#include "numerics/dense.hpp"

namespace freeplay {

using Eigen::MatrixXd, Eigen::VectorXd;

MatrixXd null_space(const MatrixXd& C, const VectorXd& weights) {
  const VectorXd back = weights.cwiseSqrt().cwiseInverse();
  if (C.rows() == 0) return back.asDiagonal();
  const MatrixXd weighted = (C * back.asDiagonal()).transpose();
  return back.asDiagonal() * orthogonal_complement(weighted, 1e-10);
}

Curvatures curvatures(const MatrixXd& K, const MatrixXd& Z, const VectorXd& weights) {
  if (Z.cols() == 0) return {VectorXd(0), VectorXd(0), Z};
  const MatrixXd H = Z.transpose() * K * Z;
  const MatrixXd symmetric = 0.5 * (H + H.transpose());
  const auto apart = symmetric_eigen(symmetric);
  Curvatures c{apart.values, {}, Z * apart.vectors};
  const MatrixXd size = K.cwiseAbs();
  const VectorXd back = weights.cwiseSqrt().cwiseInverse();
  const double all = K.size() > 0 ? (back.asDiagonal() * size * back.asDiagonal()).maxCoeff() : 0;
  c.doubt.resize(c.value.size());
  for (int d = 0; d < c.value.size(); ++d) {
    const VectorXd x = c.direction.col(d).cwiseAbs();
    c.doubt[d] = 1e-11 * x.dot(size * x) + 1e-14 * all;
  }
  return c;
}

}  // namespace freeplay
