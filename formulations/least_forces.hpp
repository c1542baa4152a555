// LeastForces: least and greatest normal forces λ_N(t) of the contacts that stay closed during an
// event-driven run. Each step is sampled on its dense output; a minimum between the samples is located
// by Brent's method. A lasting contact is lost where the least force reaches zero (lift-off).
//
// Use: construct after the scheme's start(); call add_step() after each step; then lasting().
#pragma once

#include <memory>
#include <vector>

#include "formulations/sensitivity.hpp"

namespace freeplay {

class EventDriven;
class EventDynamics;

class LeastForces {
 public:
  explicit LeastForces(const EventDriven& scheme);
  ~LeastForces();
  LeastForces(const LeastForces&) = delete;
  LeastForces& operator=(const LeastForces&) = delete;

  /// Takes the step that the scheme has just made, in the mode of this step.
  void add_step(const EventDriven& scheme);
  /// Contacts that were closed in all steps; none before the first one.
  const std::vector<EndState::Lasting>& lasting() const { return list_; }

 private:
  double force(const EventDriven& scheme, int contact, double t);

  bool begun_ = false;
  std::vector<EndState::Lasting> list_;
  std::unique_ptr<EventDynamics> probe_;
  std::vector<double> slope_;
};

}  // namespace freeplay
