// What a symmetric matrix K makes of the motions that rows C leave: with W the weights of the coordinates,
//
//     C Z = 0,    ZᵀWZ = 1,    H = ZᵀKZ.
#pragma once

#include <Eigen/Core>

namespace freeplay {

/// The null space of rows C in the metric Σ w_i dq_i²: a basis with ZᵀWZ = 1.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& C, const Eigen::VectorXd& weights);

/// H = ZᵀKZ apart into its values, with what each may be off by rounding and cancellation; `weights` as in null_space().
struct Curvatures {
  Eigen::VectorXd value, doubt;
  Eigen::MatrixXd direction;  ///< columns, in coordinates
};
Curvatures curvatures(const Eigen::MatrixXd& K, const Eigen::MatrixXd& Z, const Eigen::VectorXd& weights);

}  // namespace freeplay
