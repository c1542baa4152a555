// The options by which verbs' studies are divided, alike in each: --plan N, --shard k/N, --merge DIR (study/partition/division.hpp).
#pragma once

#include <optional>
#include <string>

#include "cli/verb.hpp"
#include "study/partition/division.hpp"

namespace freeplay::cli {

struct ShardOptions {
  int plan = 0;         ///< shards to cut the study into; 0: none
  std::string shard;    ///< "k/N"
  std::string merge;    ///< folder
  std::string scratch;  ///< of the node; empty: what the machine names
  bool asked() const { return plan > 0 || !shard.empty() || !merge.empty(); }
};

/// Declares them.
void declare_shards(Options& options, ShardOptions& into);

/// Exit status of a process that was stopped and goes on when it is asked again.
inline constexpr int stopped_status = 75;

/// Does what they ask; the exit status. `folder`: of the results, where --merge names none.
int in_shards(const Division& study, const ShardOptions& asked, const std::filesystem::path& folder,
              int threads, StopToken stop);

/// The node's own disk: --scratch, else $FREEPLAY_SCRATCH, $SLURM_TMPDIR, $TMPDIR, /tmp.
std::filesystem::path scratch_folder(const std::string& asked);

/// The study as a plan remembers it, by its whole path: jobs may run elsewhere.
std::vector<std::string> study_arguments(const std::string& file, Reach reach);

/// Threads where nobody says how many: those that Slurm gave the task, else 0, all cores.
int threads_of(int asked);

}  // namespace freeplay::cli
