// PenaltyForces: forces of a penalty run for observers, in the mode of the last step.
#pragma once

#include <vector>

#include "formulations/penalty/dynamics.hpp"
#include "formulations/probe.hpp"

namespace freeplay {

class PenaltyForces : public ForceProbe<PenaltyDynamics> {
 public:
  explicit PenaltyForces(std::size_t contacts) : modes_(contacts) {}
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
    slope_.resize(x.size());
    probe_->report(x, t, slope_, out);
  }
  /// Keeps the impulses of the last projection, which ended at x.
  void keep_projection(const PenaltyDynamics& f, const std::vector<double>& x) {
    if (!watching_) return;
    within_.clear();
    f.report_projection(x, within_);
  }

 private:
  std::vector<PenaltyMode> modes_;  // of the last step
  Phases phases_;                   // likewise
  std::vector<double> slope_;
};

}  // namespace freeplay
