// The least and the greatest value of an output over all positions that clearances permit, at one position of
// the drives, and bounds that it cannot exceed: a box that contains all poses (play_region.hpp), a search for the
// extreme (play_search.hpp), and its bound (play_bound.hpp).
//
// Where the bound does not confirm the value found, the positions are divided (branch and bound): the part with the
// greatest bound is halved along the entry of u that contributes most to its excess, until no part may exceed the
// best value found.
#pragma once

#include <Eigen/Core>

#include <optional>

#include "analysis/play/loose_mechanism.hpp"
#include "analysis/play/play_region.hpp"
#include "analysis/play/play_search.hpp"

namespace freeplay {

class PlayExtremes {
 public:
  explicit PlayExtremes(LooseMechanism& mechanism) : mechanism_(mechanism) {}

  /// Encloses all poses about the ideal pose q at time t. All other functions need its success.
  const PlayRegion& enclose(const Eigen::VectorXd& q, double t);
  /// The gradient of output k by u at u = 0, and its value there.
  double ideal(int k, Eigen::VectorXd& a);
  /// The value of output k at u; empty if the mechanism does not close there.
  std::optional<double> value(int k, const Eigen::VectorXd& u);
  /// The greatest value of sign · output k, and its bound. `start`: where the search begins (empty: at u = 0).
  /// The bound is infinite, and the value no number, where the mechanism does not close.
  PlayExtreme greatest(int k, double sign, const Eigen::VectorXd& start = {});

 private:
  LooseMechanism& mechanism_;
  PlayRegion region_;
};

}  // namespace freeplay
