// What of Slurm's commands the program uses: its words are in one file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/partition/division.hpp"

namespace freeplay::cli {

/// What a command prints, and whether it ended with status 0; none where there is no such command. A command that does not end
/// within 60 s, or $FREEPLAY_SLURM_SECONDS, is ended, and its errors begin with "no answer". Throws Interrupted.
struct Said {
  std::string text, errors;
  bool well = false;
};
std::optional<Said> ask(const std::vector<std::string>& command, StopToken stop = {});

/// What all jobs of a plan are called.
std::string job_name(const Manifest& manifest);

/// Has the job that this process is the task of run again, where it was told to stop and not cancelled.
void requeue_this_job();

}  // namespace freeplay::cli
