// Options of the verbs that make the runs of a study, which can be divided: --plan N, --shard k/N, --merge
// DIR (study/partition/division.hpp).
#pragma once

#include <optional>
#include <string>

#include "cli/command_line.hpp"
#include "study/partition/division.hpp"

namespace freeplay::cli {

/// Values of these options.
struct ShardOptions {
  int plan = 0;         ///< number of shards to plan; 0: none
  std::string shard;    ///< "k/N"
  std::string merge;    ///< folder
  std::string scratch;  ///< folder on the local disk; empty: the default of the machine
  bool requested() const { return plan > 0 || !shard.empty() || !merge.empty(); }
};

/// Options of a study's verb.
struct StudyRequest : Request {
  std::string study;  ///< file
  Reach reach = Reach::beside;
  std::string output;  ///< result folder
  int threads = 0;     ///< 0: all cores
  ShardOptions shards;
};

/// Declares the options. `file`, `output`: their meanings in the help.
void declare_shards(Options& options, ShardOptions& into);
void declare_study(Options& options, StudyRequest& into, const char* file, const char* output);

/// Whether an option divides the work of a verb.
bool divides(const std::string& option);
/// Why a verb without these options cannot be divided, and what to do instead.
std::string why_undivided(const std::string& verb);

/// Executes the options; returns the exit status. `folder`: of the results, unless --merge names
/// one.
int in_shards(const Division& study, const ShardOptions& requested, const std::filesystem::path& folder,
              int threads, StopToken stop);

/// Folder on the local disk: --scratch, else $FREEPLAY_SCRATCH, $SLURM_TMPDIR, $TMPDIR, /tmp.
std::filesystem::path scratch_folder(const std::string& requested);

/// The study's arguments in a plan, with an absolute path, because jobs may have another working
/// folder.
std::vector<std::string> study_arguments(const std::string& file, Reach reach);

}  // namespace freeplay::cli
