// Counts of memory taken: operator new and malloc of the test program are this file's own, except under AddressSanitizer.
#pragma once

namespace freeplay::test {

/// Calls of operator new by any thread.
long operator_new_calls();
/// Calls of malloc by this thread: Eigen's memory too.
long malloc_calls();

}  // namespace freeplay::test
