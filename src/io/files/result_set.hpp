// Atomic replacement of the result files of a verb. New files are made in a subfolder; the older
// results remain until all new ones exist. Then
//
//     .VERB.new  → .VERB.complete     from here on the new files are the results
//     the older files are removed
//     .VERB.complete → .VERB.moving   from here on no older file exists
//     the new files are moved to their places, and the subfolder is removed
//
// Each renaming is atomic. If the process is killed in between, the next process that opens the
// folder completes the replacement.
//
// Use: construct, write files into place(), then commit(). A ResultSet owns the lock of the folder
// and the subfolder; without commit() it removes the subfolder.
#pragma once

#include <filesystem>
#include <string>

#include "io/files/folder_lock.hpp"

namespace freeplay {

/// The new result files of one verb in one folder.
class ResultSet {
 public:
  /// Creates the folder if it does not exist, and locks it exclusively. `verb` is one of those that
  /// result_set.cpp lists with their files. Throws OutputError.
  ResultSet(const std::filesystem::path& folder, const std::string& verb);
  /// Discards the new files if they were not committed.
  ~ResultSet();
  ResultSet(const ResultSet&) = delete;
  ResultSet& operator=(const ResultSet&) = delete;

  /// Folder for the new files; their names are those of the results.
  const std::filesystem::path& place() const { return place_; }
  const FolderLock& lock() const { return lock_; }
  /// Replaces the older results, and the figures drawn from them, by the new files.
  void commit();

 private:
  /// Removes the folder again if this object created it and it is empty.
  struct Folder {
    explicit Folder(const std::filesystem::path& where);
    ~Folder();
    std::filesystem::path path;
    bool made;
  };
  Folder folder_;
  FolderLock lock_;
  std::string verb_;
  std::filesystem::path place_;
};

/// Completes replacements that a killed process began, and removes incomplete results. The caller
/// must hold the lock of the folder.
void settle_result_sets(const std::filesystem::path& folder);

}  // namespace freeplay
