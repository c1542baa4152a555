// The end of a verb: handling of signals that stop it, and messages about the end of a run.
#pragma once

#include "values/result.hpp"
#include "values/stop.hpp"

namespace freeplay::cli {

// Handling of SIGINT (Ctrl-C) and SIGTERM. The first signal requests a stop; code that receives the
// request ends normally, with complete files. If no code has received it after `patience`, there is
// nothing to complete, or a solve is in progress, and the process is killed; files are complete or
// absent at any time. A second signal kills the process at once.

inline constexpr double patience = 0.5;  ///< s, until some code must have received the request
inline constexpr double grace = 10;      ///< s, until that code must have ended

/// Installs the handlers. Returns the token for all work of this process. SIGPIPE and SIGXFSZ are
/// ignored, and the end of a child is not signalled: the calls concerned return errors.
StopToken listen_for_signals();

/// Disables the limit `grace`, for work that may take longer to complete.
void take_time();

/// Prints the reactions that mechanics does not determine.
void say_undetermined(const Result& result);

/// Exit status of a run: 0 if it finished; otherwise prints the reason to stderr.
int report(const Result& result);

/// What remains of an interrupted verb: the stored runs, or nothing.
enum class Kept { runs, nothing };

/// Prints to stderr that the user interrupted the verb, and what the same command does next.
/// Returns the exit status, 1.
int interrupted(Kept kept);

}  // namespace freeplay::cli
