// The result files of a verb, which replace those that stand in its folder as a whole. They are made in a folder beside
// these, and until all of them are there the older ones stay as they are. Then
//
//     .VERB.new  → .VERB.complete     from here on the new files are the results
//     the older files are removed
//     .VERB.complete → .VERB.moving   from here on no older file is there
//     the new files are moved to their places, and the folder that they were in is removed
//
// each step one that a kill cannot halve. Whoever opens the folder next goes on where it was left.
#pragma once

#include <filesystem>
#include <string>

#include "io/files/folder_lock.hpp"

namespace freeplay {

class ResultSet {
 public:
  /// Makes the folder where there is none and takes the right to write into it alone. `verb` is one of those that
  /// result_set.cpp lists with its files. Throws OutputError.
  ResultSet(const std::filesystem::path& folder, const std::string& verb);
  /// What is not committed has changed nothing.
  ~ResultSet();
  ResultSet(const ResultSet&) = delete;
  ResultSet& operator=(const ResultSet&) = delete;

  /// Where the files are to be made, by the names that they are to have in the folder.
  const std::filesystem::path& place() const { return place_; }
  const FolderLock& lock() const { return lock_; }
  /// The files made replace those that stand in the folder, and the figures drawn from those.
  void commit();

 private:
  /// A folder that was not there and has got nothing goes again.
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

/// Goes on where a verb was killed while it replaced its results, and removes what it had not made to the end. The
/// caller has the right to write.
void settle_result_sets(const std::filesystem::path& folder);

}  // namespace freeplay
