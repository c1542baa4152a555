// Calls of Slurm's commands. All knowledge of their options and output is in slurm.cpp.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/partition/division.hpp"

namespace freeplay::cli {

/// Output of a command, and whether its exit status was 0. nullopt if the command does not exist. A
/// command that takes more than 60 s, or $FREEPLAY_SLURM_SECONDS, is killed, and its errors begin
/// with "no answer". Throws Interrupted.
struct Said {
  std::string text, errors;
  bool well = false;
};
/// Runs a command of Slurm and returns its output, as above.
std::optional<Said> ask(const std::vector<std::string>& command, StopToken stop = {});

/// Name of all jobs of a plan.
std::string job_name(const Manifest& manifest);

/// Requeues the job of this process if it was stopped and not cancelled.
void requeue_this_job();

}  // namespace freeplay::cli
