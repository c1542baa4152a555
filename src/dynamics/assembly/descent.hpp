// Descent of the potential energy on the manifold Φ = 0 to where nothing is left that pushes: Newton's method within a trust
// region, as equilibrium.hpp says, for one set of contacts that yield and contacts that are held closed (dynamics/assembly/statics.hpp).
#pragma once

#include <optional>
#include <string>

#include "dynamics/assembly/statics.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Mechanism;

/// Throws ModelError: there is no equilibrium, and why.
[[noreturn]] void no_equilibrium(const std::string& why);

/// A place on the manifold with its reactions and what remains to move it.
struct RestPlace {
  AtRest at;
  Eigen::VectorXd mu;
  Eigen::VectorXd left;  ///< R in unit weights: what no reaction answers
};

class Descent {
 public:
  Descent(const Mechanism& mechanism, Statics& statics, const Eigen::VectorXd& from, const StopToken& stop);

  /// Down to where nothing is left but `share` of the forces; `radius` of the first step (m).
  RestPlace settle(Eigen::VectorXd q, double radius, double share = 1e-12);
  int steps = 0;

 private:
  RestPlace place(const Eigen::VectorXd& q);
  /// Onto the manifold by steps of least length; nothing where they do not come down to rounding.
  std::optional<Eigen::VectorXd> close(Eigen::VectorXd q);
  /// How far a step may go: no angle more than a radian, no contact past what it could pass unseen.
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
