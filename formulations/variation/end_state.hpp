// LeastForces: least and greatest normal forces F_N(t) of the contacts that stay closed during a run. Each
// step is sampled; a minimum between the samples is located by Brent's method. A lasting contact is lost
// where the least force reaches zero (lift-off).
//
// Use: construct; call add_step() after each step; then lasting().
#pragma once

#include <functional>
#include <vector>

#include "formulations/variation/sensitivity.hpp"

namespace freeplay {

class LeastForces {
 public:
  explicit LeastForces(int contacts) : contacts_(contacts) {}

  /// Takes a step from t0 of length h (s). `closed`: whether a contact is closed at its end; `force`: normal
  /// force (N) of a contact at a time of the step.
  void add_step(double t0, double h, const std::function<bool(int contact)>& closed,
                const std::function<double(int contact, double t)>& force);
  /// Contacts that were closed in all steps; none before the first one.
  const std::vector<EndState::Lasting>& lasting() const { return list_; }

 private:
  int contacts_;
  bool begun_ = false;
  std::vector<EndState::Lasting> list_;
};

}  // namespace freeplay
