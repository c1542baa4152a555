// WatchedForces: forces of an event-driven run for observers. It evaluates them with a second
// object of the dynamics, so that observation does not change the motion in any digit.
#pragma once

#include <memory>
#include <vector>

#include "formulations/event_driven/event_dynamics.hpp"
#include "formulations/probe.hpp"

namespace freeplay {

class WatchedForces {
 public:
  void watch(bool on, const EventDynamics& dynamics) {
    watching_ = on;
    if (on && !probe_) make_probe(dynamics);
  }
  bool watching() const { return watching_; }
  /// Called before a step.
  void clear() {
    if (!watching_) return;
    before_.clear();
    within_.clear();
  }
  void clear_before() {
    if (watching_) before_.clear();
  }
  /// Forces at x in the mode of the last step, which lasts until the next step begins.
  void at(const EventDynamics& dynamics, const std::vector<double>& x, double t, Forces& out) {
    probe_->take_mode(dynamics);
    probe_->report(x, t, out);
  }
  /// Impulses of an impact, before it is accepted.
  void apply_impact(EventDynamics& dynamics, const std::vector<double>& x,
                    const std::vector<int>& in_impact) {
    if (watching_) dynamics.report_impact(x, in_impact, impact_forces_);
  }
  void keep_impact() {
    if (watching_) before_.add(1, impact_forces_);
  }
  /// Where the impulses of projections before a step and within it are accumulated; null without
  /// observers.
  Forces* impulses_before() { return watching_ ? &before_ : nullptr; }
  Forces* impulses_within() { return watching_ ? &within_ : nullptr; }
  const Forces& before() const { return before_; }
  const Forces& within() const { return within_; }
  Forces& scratch() { return scratch_; }
  /// Number of instants at which no forces were found.
  long unreported() const { return probe_ ? probe_->counts.unreported : 0; }

  template <class M>
  void serialize(M& m, const EventDynamics& dynamics) {
    serialize_probe(m, probe_, watching_, [&] { make_probe(dynamics); });
  }

 private:
  void make_probe(const EventDynamics& dynamics) {
    probe_ = dynamics.twin();
    before_ = within_ = impact_forces_ = scratch_ = dynamics.system.make_forces();
  }

  bool watching_ = false;
  std::unique_ptr<EventDynamics> probe_;  // made when forces are first observed
  Forces before_, within_, impact_forces_, scratch_;
};

}  // namespace freeplay
