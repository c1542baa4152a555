// Merging of shards into the database that one process would have made. Shards are taken in their
// order, and the runs of each in the order of their digests, so the rows are the same for any N and
// any order of computation. The file is built on the node's local disk and then moved to its place.
// The memory use does not depend on the number of runs.
#pragma once

#include "study/partition/division.hpp"

namespace freeplay {

/// Outcome of a merge.
struct MergeSummary {
  std::size_t shards = 0, units = 0, failed = 0;
  double seconds = 0;
  bool found = false;  ///< whether it was merged before
};

/// Merges the shards of a folder into its VERB.db. Throws SceneError and changes nothing if a shard
/// is missing, damaged, or of another plan (the message names the shards, and the command that
/// computes the first), or if its file is not a database of this program
/// (study/store/database.hpp).
MergeSummary merge_shards(const Division& study, const std::filesystem::path& folder,
                          const std::filesystem::path& scratch);

/// Merges any shard files into a new file, without a plan.
void merge_files(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& into);

/// Shards without a valid seal, with the reasons. `deep`: verify the checksums of their files.
std::vector<std::pair<std::size_t, std::string>> not_whole(const Manifest& manifest,
                                                           const std::filesystem::path& folder, bool deep);

/// Short text of increasing numbers, "3, 7–9"; `dash` joins the first and last of a range.
std::string ranges(const std::vector<std::size_t>& numbers, const char* dash = "-");

}  // namespace freeplay
