// Bounds on durations that are products, such as a number of periods; the reader checks those that a file
// states. A run over 1e-308 s would never end: its steps are below the resolution of time.
#pragma once

#include <fmt/format.h>

#include <string>

#include "mechanism/error.hpp"
#include "mechanism/magnitude.hpp"

namespace freeplay {

/// Throws ModelError unless a duration (s) is 0 or in the plausible range of times.
inline void require_duration(const std::string& key, double seconds) {
  constexpr auto bounds = *magnitude_of("s");
  if (seconds == 0 || (seconds >= bounds.least && seconds <= bounds.greatest)) return;
  throw ModelError(key, fmt::format("makes a duration of {:.3g} s; it must be 0, or from {} s to {} s ({})",
                                    seconds, bounds.least, bounds.greatest, bounds.why));
}

}  // namespace freeplay
