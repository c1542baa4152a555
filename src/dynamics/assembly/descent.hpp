// Descent of the potential energy on the manifold Φ = 0 to a point without remaining force:
// Newton's method in a trust region (see equilibrium.hpp), for given elastic and closed contacts
// (dynamics/assembly/statics.hpp).
#pragma once

#include <optional>
#include <string>

#include "dynamics/assembly/statics.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Mechanism;

/// Throws ModelError: no equilibrium, with the reason.
[[noreturn]] void no_equilibrium(const std::string& why);

/// A point on the manifold with its reactions and the remaining force.
struct RestPlace {
  AtRest at;
  Eigen::VectorXd mu;
  Eigen::VectorXd left;  ///< R in unit weights: the force that no reaction balances
};

class Descent {
 public:
  Descent(const Mechanism& mechanism, Statics& statics, const Eigen::VectorXd& from, const StopToken& stop);

  /// Descends until the remaining force is below `share` of the forces; `radius` (m) of the first
  /// step.
  RestPlace settle(Eigen::VectorXd q, double radius, double share = 1e-12);
  int steps = 0;

 private:
  RestPlace place(const Eigen::VectorXd& q);
  /// Projects q onto the manifold by steps of least length; empty if they do not converge to
  /// rounding.
  std::optional<Eigen::VectorXd> close(Eigen::VectorXd q);
  /// Factor that limits a step: no angle by more than a radian, no contact by more than it could
  /// pass through undetected.
  double allowed(const Eigen::VectorXd& step) const;
  void refuse_endless(const Eigen::VectorXd& q) const;
  [[noreturn]] void refuse_stuck(const RestPlace& p, const Linearised& l) const;

  const Mechanism& mechanism_;
  Statics& s_;
  const StopToken& stop_;
  Eigen::VectorXd from_, weights_, root_;
  double reach_ = 1;
};

}  // namespace freeplay
