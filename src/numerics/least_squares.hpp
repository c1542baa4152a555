// Small least-squares problems with inequalities (Lawson and Hanson, Solving Least Squares
// Problems, 1974, chapter 23).
#pragma once

#include <Eigen/Core>

namespace freeplay {

/// Minimises |K x − y| over x ≥ 0. The caller scales the columns of K. A column whose gradient is
/// at most `none` is not added to the active set.
void nonnegative_least_squares(const Eigen::MatrixXd& K, const Eigen::VectorXd& y, Eigen::VectorXd& x,
                               double none);

/// The shortest x with G x ≥ h (least distance programming, by the dual nonnegative least squares).
/// Returns false if there is none. G and h must be of unit size and the least length below about
/// 1e4. The inequalities may be violated by `slack` if rounding makes them infeasible.
bool least_distance(const Eigen::MatrixXd& G, const Eigen::VectorXd& h, double slack, Eigen::VectorXd& x);

}  // namespace freeplay
