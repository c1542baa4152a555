// Executes the missing runs of a study on all cores and stores them. Each run is a function of its
// case only, so the results do not depend on the number of threads or of processes that share the
// work.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "study/runs/case_run.hpp"
#include "study/store/results.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

// Planning of a study: all its runs are made and checked before any result is changed. The list is
// the input of sweep().

/// A run and its key in the database.
struct PlannedRun {
  std::string key;
  Case what;
  std::size_t number = 0;  ///< in cases()
};

/// All runs of a study, without duplicates. Reads, compiles and assembles each scene, and checks
/// that it has the joints and instruments that the study names, in `threads` threads (0: all cores).
/// Throws the SceneError of the first wrong case. A stop request ends the planning early; the list is
/// then incomplete.
std::vector<PlannedRun> plan(const Study& study, const Conduct& conduct, int threads = 0);

/// Progress of a sweep, for a callback.
struct SweepProgress {
  std::size_t done = 0, total = 0;  ///< runs; includes those found and those of other processes
  double seconds_left = 0;          ///< s, estimated from the mean of this session
};

/// Outcome of a sweep.
struct SweepSummary {
  /// Number of runs; `ran` and `failed` by this process.
  std::size_t total = 0, found = 0, ran = 0, failed = 0;
  std::size_t elsewhere = 0;  ///< run by other processes during this sweep
  std::size_t kept = 0;       ///< stored by an earlier version of the study or by another program
  /// Claimed by processes that ended without storing them; they are run again.
  std::size_t lost = 0;
  bool interrupted = false;
  double wall_seconds = 0;
  long in_lanes = 0;           ///< steps of its runs that were made together with those of other runs
  std::set<std::string> keys;  ///< of all runs of the study
};

/// Executes the missing runs of `runs`, which is plan(study, conduct). Returns when all are stored,
/// also those that other processes execute. `lock` is that of the folder of `results`. `threads` 0:
/// all cores. Stored runs that the study does not name are treated as `earlier` states. Throws the
/// error of a case after storing the completed runs.
SweepSummary sweep(const Study& study, const std::vector<PlannedRun>& runs, const Conduct& conduct,
                   Results& results, const FolderLock& lock, int threads,
                   const std::function<void(const SweepProgress&)>& on_progress,
                   WorkList::Earlier earlier = WorkList::Earlier::kept);

}  // namespace freeplay
