// Forces are found by another of a stepper's dynamics, from factors with pivots of their own, so that watching
// them moves no digit of the motion.
#pragma once

#include <memory>

namespace freeplay {

/// Writes or reads the probe, if there is one. A stepper that is `watching` needs one after reading too; `make`
/// makes it as watch_forces() would.
template <class M, class Dynamics, class Make>
void remember_probe(M& m, std::unique_ptr<Dynamics>& probe, bool watching, Make make) {
  bool probed = probe != nullptr;
  m(probed);
  if constexpr (M::reading) {
    probe.reset();
    if (probed || watching) make();
  }
  if (probed) m(*probe);
}

}  // namespace freeplay
