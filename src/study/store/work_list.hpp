// The one list of the runs that a study names, in the table `work` beside them, by which processes share them: a run is
//
//     open       nobody makes it
//     claimed    the process with this seat makes it (io/files/folder_lock.hpp); when that process is gone it is open
//     done       it is among `runs`
//     kept       it is among `runs`, of an earlier form of the study or of another program
//
// Each change is one transaction that has the right to write from its beginning, so that no run is claimed twice.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "io/files/folder_lock.hpp"
#include "study/store/database.hpp"

namespace freeplay {

class WorkList {
 public:
  /// What becomes of the runs that are there and not asked for.
  enum class Earlier { kept, named };

  /// Makes these runs the list. Throws OutputError where other processes work on another.
  WorkList(const Database& database, const FolderLock& lock, const std::vector<std::string>& runs,
           Earlier earlier);
  /// Gives back what it claimed and has not made.
  ~WorkList();
  WorkList(const WorkList&) = delete;
  WorkList& operator=(const WorkList&) = delete;

  /// How many were done, and how many are kept, as the list was made.
  std::size_t found() const { return found_; }
  std::size_t kept() const { return kept_; }
  /// How many runs were claimed by processes that ended without storing them or giving them back.
  std::size_t lost() const { return lost_; }
  /// At most as many runs to be made by this process; none when all are done or made by others that live.
  std::vector<std::string> claim(int most);
  /// How many of them are done by now, by whomever.
  std::size_t done_now() const;
  /// Whether all are done.
  bool ended() const;

  /// SQL of its tables, and for a run that is stored, in the transaction that stores it.
  static constexpr std::array definitions{
      "CREATE TABLE work (run TEXT PRIMARY KEY, state TEXT, seat INTEGER)",
      "CREATE INDEX work_state ON work(state)", "CREATE TABLE sweeps (seat INTEGER PRIMARY KEY)"};
  static constexpr const char* done =
      "INSERT INTO work VALUES (?, 'done', NULL) ON CONFLICT DO UPDATE SET state = 'done', seat = NULL";

 private:
  void make_list(const std::vector<std::string>& runs, Earlier earlier);
  void forget_the_dead();
  void open_again(long seat);
  std::size_t marked_done() const;
  void require_the_others_list() const;

  const Database& database_;
  const FolderLock& lock_;
  std::size_t found_ = 0, kept_ = 0, lost_ = 0, marked_ = 0;
};

}  // namespace freeplay
