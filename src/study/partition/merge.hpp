// Shards put together: the database that one process would have made. Shards are taken in their order and the runs of each in the
// order of their digests: the same rows for any N, whoever made its shards and when. The file grows on the node's own disk and is
// brought to its place whole. Memory does not grow with the number of runs.
#pragma once

#include "study/partition/division.hpp"

namespace freeplay {

struct MergeSummary {
  std::size_t shards = 0, units = 0, failed = 0;
  double seconds = 0;
  bool found = false;  ///< it was merged already
};

/// Merges the shards of a folder into its VERB.db. Throws SceneError, and leaves everything as it is, where a shard is missing,
/// torn, or not of the plan, when the message names them and the command that makes the first; or where its file is no database
/// such as this program makes (study/store/database.hpp).
MergeSummary merge_shards(const Division& study, const std::filesystem::path& folder,
                          const std::filesystem::path& scratch);

/// The same of any shards' files into a new file; no plan is asked for.
void merge_files(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& into);

/// Which shards have no seal, or one that does not hold; `deep`: their bytes are read.
std::vector<std::pair<std::size_t, std::string>> not_whole(const Manifest& manifest,
                                                           const std::filesystem::path& folder, bool deep);

/// "3, 7–9" of numbers that grow; `dash` between first and last.
std::string ranges(const std::vector<std::size_t>& numbers, const char* dash = "-");

}  // namespace freeplay
