// Computation of one shard of a divided study, by one process. It works in a temporary folder on
// the node's local disk, because SQLite needs reliable locks, and copies complete files to the
// shared folder (study/partition/division.hpp):
//
//     while it runs        its progress, and at intervals a copy from which another node continues
//     when it is stopped   the same at once
//     when it is complete  its file, then its seal; older files of the shard are removed
//
// Two processes that compute the same shard do not conflict: their results are equal, and the last
// seal is valid.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "io/files/folder_lock.hpp"
#include "study/partition/division.hpp"

namespace freeplay {

// Temporary folder of one process on the node's local disk. It is removed with the object. Folders
// of killed processes with the same plan are removed when the next process starts; their unlocked
// lock files identify them (io/files/folder_lock.hpp).

/// Owns a temporary folder and its lock.
class Scratch {
 public:
  /// Creates a folder below `where`. Throws OutputError if that is not writable or has less than 16
  /// MB of free space.
  Scratch(const std::filesystem::path& where, const std::string& plan);
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  const FolderLock& lock() const { return *lock_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  std::unique_ptr<FolderLock> lock_;
};

/// Specification of the computation.
struct ShardRequest {
  std::size_t shard = 1;          ///< 1 … N
  std::filesystem::path scratch;  ///< folder on the node's local disk
  int threads = 0;
  StopToken stop = {};
  std::function<void(std::size_t done, std::size_t total)> on_progress = {};
  std::function<void()> on_stop = {};  ///< called on a stop, before the copy to the shared folder
};

/// Outcome of the computation.
struct ShardMade {
  Seal seal;
  bool found = false;        ///< whether it was complete before
  bool interrupted = false;  ///< the part computed so far is kept, and the same command continues
};

/// Computes a shard of the plan in the folder. Throws SceneError if the study or the program
/// differs from the plan, and OutputError if an output fails; the reason is also written to the
/// shard's state.
ShardMade make_shard(const Division& study, const std::filesystem::path& folder,
                     const ShardRequest& requested);

/// Last reported progress of a shard without a seal.
struct ShardState {
  std::string state = {};  ///< "running", "stopped" (can continue) or "failed"; "" if not begun
  std::string reason = {}, host = {}, job = {};
  std::size_t done = 0, total = 0;
  double seconds = 0;  ///< s, computing time
  double when = 0;     ///< s since 1970, time of the report
};
/// Reads the progress of a shard; an empty state if there is none or it cannot be read.
ShardState state_of(const std::filesystem::path& folder, std::size_t shard);

}  // namespace freeplay
