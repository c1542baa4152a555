// Counts allocations of memory: this file defines operator new and malloc of the test program,
// except under AddressSanitizer.
#pragma once

namespace freeplay::test {

/// Calls of operator new by any thread.
long operator_new_calls();
/// Calls of malloc by this thread: Eigen's memory too.
long malloc_calls();

}  // namespace freeplay::test
