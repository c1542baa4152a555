// Calls of Slurm's commands. All knowledge of their options and output is in slurm.cpp.
#pragma once

#include <filesystem>
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

// The two batch scripts of a divided study. Their contents come from options, folder names and
// files of possibly unknown origin. Each word is therefore quoted for the shell, and words in lines
// of #SBATCH are restricted to harmless characters.

/// Parameters of the jobs.
struct JobRequest {
  std::string study;               ///< file
  bool outside = false;            ///< it may name files outside its folder
  std::string partition, scratch;  ///< empty: not given
  std::string time;                ///< limit, in Slurm's notation
  std::string exclude;             ///< excluded nodes, separated by commas
  int cpus = 1, round = 1;
  int lead = 60;  ///< s, between the stop signal to a task and the time limit
};

/// Throws SceneError if partition, nodes, time or the folder's name contain characters that are not
/// permitted in #SBATCH lines.
void require_plain(const JobRequest& request, const std::filesystem::path& folder);

/// Excludes more nodes: those whose scratch folder failed for a shard that is `lacking`; or, if no
/// shard is lacking and a merge ended without its file, the present node. Invalid node names are
/// ignored, since the files may be of unknown origin.
void leave_out(JobRequest& request, const std::filesystem::path& folder,
               const std::vector<std::size_t>& lacking);

/// Script of a job array that computes the `lacking` shards.
std::string array_script(const JobRequest& request, const Manifest& manifest,
                         const std::filesystem::path& folder, const std::vector<std::size_t>& lacking);

/// Script of the merge job. If shards are missing, it submits them again.
std::string merge_script(const JobRequest& request, const Manifest& manifest,
                         const std::filesystem::path& folder);

}  // namespace freeplay::cli
