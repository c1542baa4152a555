// Ctrl-C (SIGINT) and SIGTERM. The first asks everybody to stop; who hears it ends in order, with whole files. What has
// not heard it after `patience` has nothing to put in order, or is deep in a solve, and is ended as it stands: files
// are whole or not there at any instant. The second ends the program at once.
#pragma once

#include "values/stop.hpp"

namespace freeplay::cli {

inline constexpr double patience = 0.5;  ///< s, for somebody to hear
inline constexpr double grace = 10;      ///< s, for those who heard to end

/// Installs the handlers; the token of all work of this process. A child's end, a closed pipe and a file grown too
/// large are told by the calls that meet them, not by signals.
StopToken listen_for_signals();

/// Nobody is ended by `grace` any more: what is being put in order may take its time.
void take_time();

}  // namespace freeplay::cli
