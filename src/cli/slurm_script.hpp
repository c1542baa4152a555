// The two batch scripts of a divided study. What stands in them comes from options, from folders' names and from files that others may
// have made: each word is quoted for the shell, and what goes to Slurm's own lines is of characters that mean nothing there.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/division.hpp"

namespace freeplay::cli {

struct JobRequest {
  std::string study;               ///< file
  bool outside = false;            ///< it may name files that do not lie beside it
  std::string partition, scratch;  ///< empty: none is named
  std::string time;                ///< limit as Slurm takes it
  int cpus = 1, round = 1;
  int lead = 60;  ///< s before the limit that a task is told to stop
};

/// Throws SceneError where partition, time or the folder's name hold what a line of #SBATCH cannot.
void require_plain(const JobRequest& request, const std::filesystem::path& folder);

/// Makes the shards that are `lacking`, as an array. Nodes whose scratch refused a shard are left out.
std::string array_script(const JobRequest& request, const Manifest& manifest,
                         const std::filesystem::path& folder, const std::vector<std::size_t>& lacking);

/// Merges; where shards are missing, submits them again.
std::string merge_script(const JobRequest& request, const Manifest& manifest,
                         const std::filesystem::path& folder);

}  // namespace freeplay::cli
