// Handling of SIGINT (Ctrl-C) and SIGTERM. The first signal requests a stop; code that receives the
// request ends normally, with complete files. If no code has received it after `patience`, there is
// nothing to complete, or a solve is in progress, and the process is killed; files are complete or
// absent at any time. A second signal kills the process at once.
#pragma once

#include "values/stop.hpp"

namespace freeplay::cli {

inline constexpr double patience = 0.5;  ///< s, until some code must have received the request
inline constexpr double grace = 10;      ///< s, until that code must have ended

/// Installs the handlers. Returns the token for all work of this process. SIGPIPE and SIGXFSZ are
/// ignored, and the end of a child is not signalled: the calls concerned return errors.
StopToken listen_for_signals();

/// Disables the limit `grace`, for work that may take longer to complete.
void take_time();

}  // namespace freeplay::cli
