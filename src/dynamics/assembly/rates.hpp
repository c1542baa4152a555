// Velocities of a start: G v + Φ_t = 0 at its positions (stated.hpp).
#pragma once

#include <Eigen/Core>

#include <vector>

#include "dynamics/assembly/closure.hpp"
#include "values/state.hpp"

namespace freeplay {

// Restriction of a symmetric matrix K to the motions that rows C allow. With the weights W of the
// coordinates,
//
//     C Z = 0,    ZᵀWZ = 1,    H = ZᵀKZ.

/// A basis Z of the null space of C, with ZᵀWZ = 1, W = diag(weights).
Eigen::MatrixXd null_space(const Eigen::MatrixXd& C, const Eigen::VectorXd& weights);

/// Eigenvalues of H = ZᵀKZ with their error bounds from rounding and cancellation; `weights` as in
/// null_space().
struct Curvatures {
  Eigen::VectorXd value, doubt;
  Eigen::MatrixXd direction;  ///< eigenvectors as columns, in the coordinates q
};
Curvatures curvatures(const Eigen::MatrixXd& K, const Eigen::MatrixXd& Z, const Eigen::VectorXd& weights);

struct Mechanism;
class System;

/// Completes the velocities of s at its positions. `stated` ones are kept, or change by the least
/// mass-weighted amount if they contradict the constraints; the others change least from those in s.
/// Returns the row that the stated velocities violate most (m/s, rad/s). Throws ModelError if no
/// velocities satisfy all rows.
OpenJoint assemble_velocities(const Mechanism& mechanism, const System& system,
                              const std::vector<char>& stated, State& s);

}  // namespace freeplay
