// PenaltyForces: forces of a penalty run for observers. It evaluates them with a second object of the
// dynamics in the mode of the last step, so that observation does not change the motion in any digit.
#pragma once

#include <memory>
#include <vector>

#include "formulations/penalty/dynamics.hpp"
#include "formulations/probe.hpp"

namespace freeplay {

class PenaltyForces {
 public:
  void watch(bool on, const PenaltyDynamics& f) {
    watching_ = on;
    if (on && !probe_) make_probe(f);
  }
  /// Called before a step: keeps its mode.
  void keep_mode(const PenaltyDynamics& f) {
    if (!watching_) return;
    modes_.assign(f.contacts().begin(), f.contacts().end());
    phases_ = f.phases;
  }
  /// Forces at x within the last step.
  void at(const PenaltyDynamics& f, const std::vector<double>& x, double t, Forces& out) {
    for (std::size_t k = 0; k < modes_.size(); ++k) probe_->contacts()[k].mode() = modes_[k];
    probe_->phases = phases_;
    probe_->knot = f.knot;
    probe_->report(x, t, slope_, out);
  }
  /// Keeps the impulses of the last projection, which ended at x.
  void keep_projection(const PenaltyDynamics& f, const std::vector<double>& x) {
    if (!watching_) return;
    within_.clear();
    f.report_projection(x, within_);
  }
  const Forces& before() const { return nothing_; }
  const Forces& within() const { return within_; }
  Forces& scratch() { return scratch_; }

  template <class M>
  void serialize(M& m, const PenaltyDynamics& f) {
    serialize_probe(m, probe_, watching_, [&] { make_probe(f); });
  }

 private:
  void make_probe(const PenaltyDynamics& f) {
    probe_ = f.twin();
    modes_.resize(f.contacts().size());
    slope_.resize(static_cast<std::size_t>(f.size()));
    nothing_ = within_ = scratch_ = f.system().make_forces();
  }

  bool watching_ = false;
  std::unique_ptr<PenaltyDynamics> probe_;  // made when forces are first observed
  std::vector<PenaltyMode> modes_;          // of the last step
  Phases phases_;                           // likewise
  Forces nothing_, within_, scratch_;
  std::vector<double> slope_;
};

}  // namespace freeplay
