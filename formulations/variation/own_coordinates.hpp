// OwnCoordinates: a mechanism's own coordinates of tangent vectors, without constraints and driven
// coordinates. With G the Jacobian of the constraints of joints and drives and M the mass matrix,
//
//     G Z = 0,   Zᵀ M Z = 1,      u = (Zᵀ M δq, T Zᵀ M δv, δz/scale),
//
// so that a tangent vector has 2f components for f degrees of freedom, and one for each first-order state
// of elements. T is a constant time. Used by tangent_run.hpp.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "numerics/dense.hpp"

namespace freeplay {

class System;
struct Scene;
struct State;

class OwnCoordinates {
 public:
  using Vector = std::vector<double>;

  /// T is the time scale of the scene from this start.
  OwnCoordinates(const Scene& scene, const System& system, const State& start);
  double time() const { return time_; }

  /// M^(1/2) Z in columns, at the integrated vector x, which begins with (q, v).
  Eigen::MatrixXd motions(const Vector& x, double t) const;
  /// u of a column of the integrated vector, whose first-order states begin at `states`.
  Eigen::VectorXd of(const Eigen::MatrixXd& Z, const Vector& column, int states) const;
  /// u of several columns, in columns.
  Eigen::MatrixXd of(const Eigen::MatrixXd& Z, const std::vector<Vector>& columns, int states) const;
  /// A basis: displacements of (q, v, z).
  std::vector<Vector> basis(const Eigen::MatrixXd& Z) const;

  /// What orthonormalise() needs beside the columns.
  struct Basis {
    const Eigen::MatrixXd& Z;
    int states = 0;  ///< place of the first-order states in a column
    double t = 0;    ///< s
    /// Reasons of the collapse of each column, which are extended.
    std::vector<std::string>& collapsed;
    /// Called at the collapse of a column.
    std::function<void(std::size_t column)> on_collapse;
  };
  /// Replaces columns by an orthonormal basis of their span, in their order (QR). Returns the logarithm of
  /// the length of each beside those before it; −∞ for one that has collapsed.
  std::vector<double> orthonormalise(std::vector<Vector>& columns, const Basis& basis) const;

 private:
  const System& system_;
  double time_ = 1;
};

/// A vector of which less than this remains beside those before it has collapsed: restitution 0, sticking or
/// a lasting contact removes a coordinate, up to the errors of the differences at events (1e-12).
inline constexpr double collapsed_share = 1e-9;

}  // namespace freeplay
