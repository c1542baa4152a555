// Runs work in its own process, so that a crash, a hang or growing memory ends with that process.
#pragma once

#include <functional>
#include <string>

namespace freeplay::verification {

/// Outcome of the work.
struct Apart {
  std::string said;      ///< by the work; its output up to a premature end
  bool late = false;     ///< ended by the time limit
  int signal = 0;        ///< the signal that ended it
  double megabytes = 0;  ///< greatest memory use, including that at the start
};

/// Runs `work` in a copy of this process for at most `seconds`; the copy ends with this process.
/// Its exceptions are lost, and nothing is reported.
Apart run_apart(const std::function<std::string()>& work, double seconds);

/// The same for work with intermediate output: the output before a premature end is kept, and
/// `seconds` limits the time from one output to the next.
using Say = std::function<void(const std::string&)>;
Apart run_apart(const std::function<void(const Say&)>& work, double seconds);

}  // namespace freeplay::verification
