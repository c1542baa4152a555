// Temporary folder of one process on the node's local disk. It is removed with the object. Folders
// of killed processes with the same plan are removed when the next process starts; their unlocked
// lock files identify them (io/files/folder_lock.hpp).
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "io/files/folder_lock.hpp"

namespace freeplay {

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

}  // namespace freeplay
