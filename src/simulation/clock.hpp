// The clock for the CPU time of runs.
#pragma once

#include <ctime>

namespace freeplay {

/// CPU seconds of the calling thread. A run uses one thread, and other runs may use other threads
/// at the same time.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace freeplay
