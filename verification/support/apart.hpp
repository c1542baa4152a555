// Runs work in its own process, so that a crash, a hang or growing memory ends with that process.
#pragma once

#include <functional>
#include <string>

namespace freeplay::verification {

/// What came of it.
struct Apart {
  std::string said;      ///< by the work; what it had written when it did not end well
  bool late = false;     ///< ended for want of time
  int signal = 0;        ///< that it died of
  double megabytes = 0;  ///< the most memory that it held, with what it was begun with
};

/// Runs `work` in a copy of this process for at most `seconds`, which ends with this process. What it throws is
/// lost, and nothing is said.
Apart run_apart(const std::function<std::string()>& work, double seconds);

/// The same of work that speaks as it goes on: what it had said when it ended early is kept, and it has `seconds` from one
/// word to the next.
using Say = std::function<void(const std::string&)>;
Apart run_apart(const std::function<void(const Say&)>& work, double seconds);

}  // namespace freeplay::verification
