// The search for the greatest value of an output h(u) over all positions u within the clearances.
//
// h increases most along its gradient a; on U the linear function a·u is greatest at u_k = a_k/|a_k|. Setting u to
// it repeatedly converges like (clearance/length)ⁿ, unless a joint has next to no influence. Then Ipopt maximises h
// on U from several starts with exact first and second derivatives.
#pragma once

#include <Eigen/Core>

#include "analysis/play/play_output.hpp"

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
void ascend(PlayOutput& h, PlayExtreme& x);
/// Replaces `best` by the best of local maxima from several starts; it is the first one.
void search_from_starts(PlayOutput& h, PlayExtreme& best);

}  // namespace freeplay
