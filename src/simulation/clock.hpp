// The clock that runs are charged by.
#pragma once

#include <ctime>

namespace freeplay {

/// CPU seconds of the calling thread: a run is one thread's, and others may run beside it.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace freeplay
