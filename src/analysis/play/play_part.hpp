// PlayPart: a part of the positions u ∈ U within the clearances: those in a box low ≤ u ≤ high. Of a revolute joint
// it is the box cut with the unit disc.
#pragma once

#include <Eigen/Core>

#include <utility>

#include "analysis/play/loose_mechanism.hpp"

namespace freeplay {

struct PlayPart {
  Eigen::VectorXd low, high;

  static PlayPart whole(int size) {
    return {Eigen::VectorXd::Constant(size, -1), Eigen::VectorXd::Constant(size, 1)};
  }
  /// Whether all components have a position in it.
  bool has_positions(const std::vector<LooseComponent>& components) const;
  /// The position of the component nearest to `target`.
  Eigen::VectorXd nearest(const LooseComponent& c, const Eigen::VectorXd& target) const;
  /// The position at which a·u_k is greatest.
  Eigen::VectorXd farthest(const LooseComponent& c, const Eigen::VectorXd& a) const;
  /// Restricts the component to a box of the positions farthest along any direction that is within `error` of a;
  /// no restriction if this may be 0.
  void restrict_to_farthest(const LooseComponent& c, const Eigen::VectorXd& a, double error);
  /// Both halves of the range of entry i.
  std::pair<PlayPart, PlayPart> halves(int i) const;
};

}  // namespace freeplay
