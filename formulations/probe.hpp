// Serialization of a probe: a second copy of a stepper's dynamics that evaluates forces for an
// observer. The copy has its own factorisations and pivots, so that observing forces does not
// change the motion in any digit.
#pragma once

#include <memory>

namespace freeplay {

/// Writes or restores the probe, if there is one. A stepper that is `watching` also needs a probe
/// after restoring; `make` creates it as watch_forces() does.
template <class M, class Dynamics, class Make>
void serialize_probe(M& m, std::unique_ptr<Dynamics>& probe, bool watching, Make make) {
  bool probed = probe != nullptr;
  m(probed);
  if constexpr (M::reading) {
    probe.reset();
    if (probed || watching) make();
  }
  if (probed) m(*probe);
}

}  // namespace freeplay
