// Child processes: runs another program (gnuplot, ffmpeg, a command of Slurm) within a time limit.
// The command has a process group of its own, which ends with it, at its time limit, on a stop request,
// and when this process ends, even by SIGKILL. run_child() blocks, owns the pipes to the child, needs no
// signal handlers (it raises no SIGPIPE), and keeps no state afterwards.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "values/stop.hpp"

namespace freeplay {

/// A command and its limits.
struct Child {
  std::vector<std::string>
      command;  ///< program, searched in PATH, and its arguments; executed without a shell
  std::filesystem::path folder = {};  ///< working folder; empty: that of this process
  std::string_view input = {};        ///< text for its standard input, which then ends
  double seconds = 60;                ///< s, after which it is killed
  bool listen = false;                ///< whether its standard output is returned
  StopToken stop = {};                ///< stop request, which also kills it
  /// Whether the folder is also its TMPDIR, and is removed if this process ends before it.
  bool temporary = false;
};

/// How a child ended.
struct ChildEnd {
  int status = 0;      ///< exit status; 128 + N after signal N; 127 if it could not be started
  bool late = false;   ///< whether it was killed at the time limit
  std::string output;  ///< its standard output if `listen`, the first 16 MB
  std::string errors;  ///< its standard error, the first 64 kB
};

/// Runs the command to its end. Throws Interrupted on a stop request, and OutputError if no process
/// can be created.
ChildEnd run_child(const Child& child);

}  // namespace freeplay
