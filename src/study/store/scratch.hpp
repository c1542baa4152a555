// A folder of one process' own on the node's own disk, gone with it. What killed processes left there of the same plan goes when
// the next of them begins; that they are gone their lock tells (io/files/folder_lock.hpp).
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "io/files/folder_lock.hpp"

namespace freeplay {

class Scratch {
 public:
  /// Below `where`. Throws OutputError where that cannot be written or has less than 16 MB of room.
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
