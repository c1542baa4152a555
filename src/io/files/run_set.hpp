// The files of a run, which replace those of an earlier one in their folder as a whole. They grow as NAME.partial beside
// the older ones; run.json.partial is written last, when all others are complete. So
//
//     run.json.partial is whole  ⇔  the new run has ended, and is what the folder holds
//
// (a JSON object that is cut off anywhere is none). From then on the older files are removed, run.json first and all before
// the first new one is put in its place, trajectory.csv, which every run has; run.json is the last. Whoever opens the
// folder of a run that was killed meanwhile can tell where it was and goes on there.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/output_file.hpp"

namespace freeplay {

inline constexpr const char* checkpoint_name = "run.checkpoint";

/// The end of a run. What it does in this order: summarise, remove_older, the files' own commits in the order of their
/// names here, commit.
class RunSet {
 public:
  /// `names`: the files that the run writes beside run.json, trajectory.csv first.
  RunSet(const std::filesystem::path& folder, std::vector<std::string> names);
  /// Writes run.json beside its place; the others have been handed over whole.
  void summarise(std::string_view text);
  void remove_older();
  /// Removes the checkpoint unless the run goes on `later`, and puts run.json in its place.
  void commit(bool later);

 private:
  std::filesystem::path folder_;
  OutputFile summary_;
};

/// Goes on where a run was killed after its end. Of one that was killed before, nothing is touched: it may be resumed. The
/// caller has the right to write.
void settle_run(const std::filesystem::path& folder);

/// Whether a run that has ended stands in the folder, one that was not interrupted.
bool holds_finished_run(const std::filesystem::path& folder);

/// Throws SnapshotError unless each of these files has its half beside its place.
void require_halves(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace freeplay
