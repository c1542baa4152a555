// Runs what is missing of a study on all cores and stores it. Results do not depend on the number of threads, nor on that
// of the processes that share the work: every run is a function of its case alone.
#pragma once

#include <functional>
#include <set>

#include "study/settings/plan.hpp"
#include "study/store/results.hpp"
#include "study/store/work_list.hpp"

namespace freeplay {

struct SweepProgress {
  std::size_t done = 0, total = 0;  ///< runs, those found and those of others included
  double seconds_left = 0;          ///< by the mean of this session
};

struct SweepSummary {
  std::size_t total = 0, found = 0, ran = 0, failed = 0;  ///< `ran` and `failed` by this process
  std::size_t elsewhere = 0;  ///< made meanwhile by other processes that share the study
  std::size_t kept = 0;       ///< of an earlier form of the study, or made by another program
  std::size_t lost = 0;  ///< that processes had claimed which ended without storing them; they are made again
  bool interrupted = false;
  double wall_seconds = 0;
  std::set<std::string> keys;  ///< of all its runs
};

/// Makes what is missing of `runs`, which is plan(study, conduct), and ends when all are there: those that other processes
/// are making are waited for. `lock` holds the folder of `results`. `threads` 0: all cores. Runs that the study does not
/// name stay, marked as kept, or named as before. Throws what a case throws, after the runs that are made are stored.
SweepSummary sweep(const Study& study, const std::vector<PlannedRun>& runs, const Conduct& conduct,
                   Results& results, const FolderLock& lock, int threads,
                   const std::function<void(const SweepProgress&)>& on_progress,
                   WorkList::Earlier earlier = WorkList::Earlier::kept);

}  // namespace freeplay
