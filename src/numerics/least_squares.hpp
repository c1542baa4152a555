// Small least-squares problems with inequalities (Lawson and Hanson, Solving Least Squares Problems, 1974, chapter 23).
#pragma once

#include <Eigen/Core>

namespace freeplay {

/// Least |K x − y| over x ≥ 0. Columns of K are scaled by whoever calls; a column whose gradient is at most `none` does
/// not help.
void nonnegative_least_squares(const Eigen::MatrixXd& K, const Eigen::VectorXd& y, Eigen::VectorXd& x,
                               double none);

/// The x of least length with G x ≥ h (least distance programming, by the dual nonnegative least squares). False where
/// there is none: G and h are to be of unit size, the least length below about 1e4. They may be missed by
/// `slack` where rounding lets them not be met.
bool least_distance(const Eigen::MatrixXd& G, const Eigen::VectorXd& h, double slack, Eigen::VectorXd& x);

}  // namespace freeplay
