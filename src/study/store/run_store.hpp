// Common part of the databases of runs (sweeps, attractors, ensembles): one SQLite file with one
// row in `runs` for each run, with the digest of its identity as key, and rows of other tables that
// refer to it. Each run is stored completely in one transaction, alone or with others. A program
// that is stopped at any time therefore leaves complete runs only, and the next one continues with
// the missing runs.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "io/files/folder_lock.hpp"
#include "study/store/database.hpp"
#include "values/identity.hpp"

namespace freeplay {

/// Key of a run in its database: digest of the identity that it shares with other runs, with the lines that
/// distinguish it from them at the end of `given`. Equal keys imply equal bits.
std::string run_key(Identity shared, const std::string& lines);
/// Likewise of one of several starts.
std::string run_key(Identity all_starts, int start);

// List of the runs of a study, in the table `work` of its database, by which processes divide the
// runs. Its column `seat` is the slot of the process that computes a run. A run is
//
//     open       not begun
//     claimed    computed by the process with this slot (io/files/folder_lock.hpp); open again if
//                that process has ended
//     done       stored in `runs`
//     kept       stored in `runs`, from an earlier version of the study or another program
//
// Each change is one transaction with a write lock from its beginning, so no run is claimed twice.

/// The work list of one database. Refers to the database and the folder lock.
class WorkList {
 public:
  /// State of stored runs that are not in the new list: kept, or done.
  enum class Earlier { kept, named };

  /// Writes the list. Throws OutputError if other processes work on another list.
  WorkList(const Database& database, const FolderLock& lock, const std::vector<std::string>& runs,
           Earlier earlier);
  /// Returns claimed runs that were not stored.
  ~WorkList();
  WorkList(const WorkList&) = delete;
  WorkList& operator=(const WorkList&) = delete;

  /// Numbers of runs that were done and kept when the list was written.
  std::size_t found() const { return found_; }
  std::size_t kept() const { return kept_; }
  /// Number of runs claimed by processes that ended without storing or returning them.
  std::size_t lost() const { return lost_; }
  /// Claims at most `most` runs for this process. Empty if all are done or claimed by living
  /// processes.
  std::vector<std::string> claim(int most);
  /// Number of runs of the list that are done now, by any process.
  std::size_t done_now() const;
  /// Whether all runs are done.
  bool ended() const;

  /// SQL of its tables, and of the statement that marks a run as done in the transaction that
  /// stores it.
  static constexpr std::array definitions{
      "CREATE TABLE work (run TEXT PRIMARY KEY, state TEXT, seat INTEGER)",
      "CREATE INDEX work_state ON work(state)", "CREATE TABLE sweeps (seat INTEGER PRIMARY KEY)"};
  static constexpr const char* done =
      "INSERT INTO work VALUES (?, 'done', NULL) ON CONFLICT DO UPDATE SET state = 'done', seat = NULL";

 private:
  void make_list(const std::vector<std::string>& runs, Earlier earlier);
  void release_claims_of_ended_processes();
  /// Removes the process with this slot from the lists. Returns the number of its claims, which are
  /// open again.
  std::size_t release(long slot);
  std::size_t marked_done() const;
  void require_the_others_list() const;

  const Database& database_;
  const FolderLock& lock_;
  std::size_t found_ = 0, kept_ = 0, lost_ = 0, marked_ = 0;
};

/// Definition of a database of runs. Its kind is stored in user_version: 0, sweeps with keys made
/// of the commit and a list of fields; 1, sweeps with digests of identities as keys and one row for
/// each harmonic and sample; 2, attractors; 3, ensembles, and sweeps with blobs and integer
/// references.
struct StoreForm {
  long kind = 0;
  std::string columns;  ///< of `runs`, in SQL
  std::span<const ListOfRuns> lists;
  bool divided = false;  ///< whether processes divide the runs by a WorkList
};

/// Base class of databases of runs. Owns the Database.
class RunStore {
 public:
  const Database& database() const { return database_; }

 protected:
  /// Opens the file. Creates tables and indexes in an empty file that is opened for writing. Throws
  /// OutputError if the file has other definitions.
  RunStore(const std::filesystem::path& file, Database::Access access, const StoreForm& form, StopToken stop);
  ~RunStore() = default;

  Database database_;
};

}  // namespace freeplay
