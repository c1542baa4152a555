// The stepping loop, one instance for each kind of stepper: no virtual call, no allocation, no string inside.
#pragma once

#include "sim/formulation.hpp"
#include "sim/recorder.hpp"

namespace freeplay {

/// A Stepper has step(t_end), which advances by one step not beyond t_end and is false when it cannot (then
/// failure() says why), and what Recorder::accept asks for.
template <class Stepper>
Ending march(Stepper& stepper, double t_end, ContactLog& log, Recorder& recorder) {
  while (stepper.t() < t_end) {
    if (stop_requested.load(std::memory_order_relaxed)) return {Ending::Status::interrupted, "interrupted"};
    if (!stepper.step(t_end)) return {Ending::Status::failed, stepper.failure()};
    log.advance(stepper.t());
    recorder.accept(stepper, log);
  }
  return {};
}

}  // namespace freeplay
