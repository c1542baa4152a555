// The two batch scripts of a divided study. What stands in them comes from options, from folders' names and from files that others may
// have made: each word is quoted for the shell, and what goes to Slurm's own lines is of characters that mean nothing there.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/partition/division.hpp"

namespace freeplay::cli {

struct JobRequest {
  std::string study;               ///< file
  bool outside = false;            ///< it may name files that do not lie beside it
  std::string partition, scratch;  ///< empty: none is named
  std::string time;                ///< limit as Slurm takes it
  std::string exclude;             ///< nodes that get no task, with commas between them
  int cpus = 1, round = 1;
  int lead = 60;  ///< s before the limit that a task is told to stop
};

/// Throws SceneError where partition, nodes, time or the folder's name hold what a line of #SBATCH cannot.
void require_plain(const JobRequest& request, const std::filesystem::path& folder);

/// Adds nodes that are to be left out: those whose scratch refused a shard that is `lacking`; where none is lacking and a merge has
/// ended without its file, the node that this is asked on. Names that no machine has are passed over: files may be anyone's.
void leave_out(JobRequest& request, const std::filesystem::path& folder,
               const std::vector<std::size_t>& lacking);

/// Makes the shards that are `lacking`, as an array.
std::string array_script(const JobRequest& request, const Manifest& manifest,
                         const std::filesystem::path& folder, const std::vector<std::size_t>& lacking);

/// Merges; where shards are missing, submits them again.
std::string merge_script(const JobRequest& request, const Manifest& manifest,
                         const std::filesystem::path& folder);

}  // namespace freeplay::cli
