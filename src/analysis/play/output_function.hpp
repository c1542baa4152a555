// OutputFunction: an output h(u) = ± y(Q(u)) with its derivatives by the numbers u within the clearances, at one
// position of the drives.
//
// With the adjoint λ, F_qᵀ λ = ± ∇y, the gradient is a = −F_uᵀ λ. With S = −F_q⁻¹ F_u, the second derivatives are
//
//     ∂²h/∂u² = (S, I)ᵀ p″ (S, I),      p(q, u) = ± y − λᵀ F.
#pragma once

#include <Eigen/Core>

#include <optional>

#include "analysis/play/play_region.hpp"

namespace freeplay {

class OutputFunction {
 public:
  /// ± output k of the mechanism; `region` is that of the position.
  OutputFunction(LooseMechanism& mechanism, const PlayRegion& region, int k, double sign)
      : mechanism(mechanism), region(region), k(k), sign(sign) {}

  /// Closes the mechanism at u, from the pose q, which becomes that of u; false if it does not close. Sets the
  /// members below.
  bool evaluate(const Eigen::VectorXd& u, Eigen::VectorXd& q);
  /// evaluate() from the pose of the linear mechanism.
  bool evaluate(const Eigen::VectorXd& u);
  /// ∂²h/∂u² at the last evaluate(), whose u is given.
  Eigen::MatrixXd second(const Eigen::VectorXd& u);

  LooseMechanism& mechanism;
  const PlayRegion& region;
  const int k;
  const double sign;

  double value = 0;           ///< h
  double rounding = 0;        ///< of h and of the terms of its bound (play_bound.hpp)
  Eigen::VectorXd a, lambda;  ///< gradient and adjoint
  LooseMechanism::Equations f;
  DenseLu factors;  ///< of F_q

 private:
  Eigen::VectorXd gradient_, pose_;
};

}  // namespace freeplay
