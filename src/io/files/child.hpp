// Another program run as a child of this one, within a time, and never longer than this one lives.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "values/stop.hpp"

namespace freeplay {

struct Child {
  std::vector<std::string>
      command;  ///< the program, looked for in PATH, and its arguments; no shell reads them
  std::filesystem::path folder = {};  ///< where it runs; empty: where this one does
  std::string_view input = {};        ///< for its standard input, which then ends
  double seconds = 60;                ///< after which it is ended
  bool listen = false;                ///< whether its standard output is kept
  StopToken stop = {};                ///< ends it, too
};

struct ChildEnd {
  int status = 0;     ///< exit status; 128 + signal for one that a signal ended; 127: it could not be started
  bool late = false;  ///< ended, for its time was over
  std::string output;  ///< what it wrote to standard output where that is kept, the first 16 MB
  std::string errors;  ///< what it wrote to standard error, the first 64 kB
};

/// Runs it to its end. Throws Interrupted when asked to stop, OutputError when no
/// process can be made.
ChildEnd run_child(const Child& child);

}  // namespace freeplay
