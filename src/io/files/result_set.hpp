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
#include <string_view>
#include <vector>

#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"

namespace freeplay {

// Atomic replacement of the files of a run. The new files grow as NAME.partial beside the files of
// an earlier run, and run.json.partial is written last, when all others are complete. Hence
//
//     run.json.partial is complete  ⇔  the new run has ended, and its files are the results
//
// (a truncated JSON object is not valid JSON). Then all older files are removed, run.json first,
// and the new files are renamed, trajectory.csv, which every run has, first and run.json last. If
// the process is killed in between, settle_run() determines from the present files which of these
// steps were done, and completes the rest.

/// File name of the checkpoint in a result folder.
inline constexpr const char* checkpoint_name = "run.checkpoint";

/// The replacement at the end of a run. Order of calls: summarise(), remove_older(), commit() of
/// the other files in the order of their names here, commit().
class RunSet {
 public:
  /// `names`: the files of the run beside run.json, trajectory.csv first.
  RunSet(const std::filesystem::path& folder, std::vector<std::string> names);
  /// Writes run.json.partial. All other files must have been flushed.
  void summarise(std::string_view text);
  void remove_older();
  /// Renames run.json to its final name. Removes the checkpoint unless the run continues `later`.
  void commit(bool later);

 private:
  std::filesystem::path folder_;
  OutputFile summary_;
};

/// Completes the replacement of a run that was killed after its end. Does nothing for a run that
/// was killed before, which can be resumed. The caller must hold the lock of the folder.
void settle_run(const std::filesystem::path& folder);

/// Whether the folder contains a run that has ended without interruption.
bool holds_finished_run(const std::filesystem::path& folder);

/// Throws SnapshotError unless the partial file of each name exists.
void require_halves(const std::filesystem::path& folder, const std::vector<std::string>& names);

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
