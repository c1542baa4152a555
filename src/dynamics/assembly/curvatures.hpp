// Restriction of a symmetric matrix K to the motions that rows C allow. With the weights W of the
// coordinates,
//
//     C Z = 0,    ZᵀWZ = 1,    H = ZᵀKZ.
#pragma once

#include <Eigen/Core>

namespace freeplay {

/// A basis Z of the null space of C, with ZᵀWZ = 1, W = diag(weights).
Eigen::MatrixXd null_space(const Eigen::MatrixXd& C, const Eigen::VectorXd& weights);

/// Eigenvalues of H = ZᵀKZ with their error bounds from rounding and cancellation; `weights` as in
/// null_space().
struct Curvatures {
  Eigen::VectorXd value, doubt;
  Eigen::MatrixXd direction;  ///< eigenvectors as columns, in the coordinates q
};
Curvatures curvatures(const Eigen::MatrixXd& K, const Eigen::MatrixXd& Z, const Eigen::VectorXd& weights);

}  // namespace freeplay
