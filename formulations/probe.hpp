// ForceProbe: forces of a run for observers. It evaluates them with a second object of a stepper's dynamics,
// which has its own factorisations and pivots, so that observed motions are bitwise identical to others.
#pragma once

#include <memory>

#include "dynamics/system.hpp"

namespace freeplay {

template <class Dynamics>
class ForceProbe {
 public:
  void watch(bool on, const Dynamics& dynamics, const System& system) {
    watching_ = on;
    if (on && !probe_) make(dynamics, system);
  }
  bool watching() const { return watching_; }
  /// Impulses before the last step, and of instants within it.
  const Forces& before() const { return before_; }
  const Forces& within() const { return within_; }
  Forces& scratch() { return scratch_; }

  /// Writes or restores the probe, if there is one. A stepper that is watched also needs one after restoring.
  template <class M>
  void serialize(M& m, const Dynamics& dynamics, const System& system) {
    bool probed = probe_ != nullptr;
    m(probed);
    if constexpr (M::reading) {
      probe_.reset();
      if (probed || watching_) make(dynamics, system);
    }
    if (probed) m(*probe_);
  }

 protected:
  bool watching_ = false;
  std::unique_ptr<Dynamics> probe_;  // made when forces are first observed
  Forces before_, within_, scratch_;

 private:
  void make(const Dynamics& dynamics, const System& system) {
    probe_ = dynamics.twin();
    before_ = within_ = scratch_ = system.make_forces();
  }
};

}  // namespace freeplay
