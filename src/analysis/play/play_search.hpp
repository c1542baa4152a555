// The search for the greatest value of an output h(u) in a part V of the positions within the clearances.
//
// h increases most along its gradient a; on V the linear function a·u is greatest at the position of each
// component that is farthest along a_k, without limits of the part at u_k = a_k/|a_k|. ascend() sets u to it
// repeatedly, which converges like (clearance/length)ⁿ, unless a joint has next to no influence. climb() then
// maximises the quadratic model
//
//     a·δu + ½ δuᵀ H δu,     H = ∂²h/∂u²
//
// by steps of single components, v_k = the position nearest to v_k + g_k/|H_kk| with the gradient g of the model, and
// closes the mechanism at the result. It converges to a local maximum.
#pragma once

#include <Eigen/Core>

#include "analysis/play/output_function.hpp"
#include "analysis/play/play_part.hpp"

namespace freeplay {

/// One end of the range of an output.
struct PlayExtreme {
  double value = 0;      ///< found
  double bound = 0;      ///< cannot be exceeded
  Eigen::VectorXd u;     ///< where it was found
  Eigen::VectorXd q;     ///< the pose
  Eigen::VectorXd a;     ///< gradient of the output by u
  bool settled = false;  ///< whether the search converged
};

/// Follows the gradient from x.u and x.q.
void ascend(OutputFunction& h, const PlayPart& part, PlayExtreme& x);
/// Moves x to a local maximum.
void climb(OutputFunction& h, const PlayPart& part, PlayExtreme& x);

}  // namespace freeplay
