// Runs what is missing of a study on all cores and stores it. Results do not depend on the number of threads:
// every run is a function of its case alone.
#pragma once

#include <functional>
#include <set>

#include "study/results.hpp"

namespace freeplay {

struct SweepProgress {
  std::size_t done = 0, total = 0;  ///< runs, those found included
  double seconds_left = 0;          ///< by the mean of this session
};

struct SweepSummary {
  std::size_t total = 0, found = 0, ran = 0, failed = 0;
  std::size_t dropped = 0;  ///< of an earlier form of the study, or made by another program
  bool interrupted = false;
  double wall_seconds = 0;
  std::set<std::string> keys;  ///< of all its runs
};

/// `threads` 0: all cores. Runs of an earlier form of the study or of another program are
/// removed, or with `keep_others` stay. Throws what a case throws (bad scenes), after the runs under way are
/// stored.
SweepSummary sweep(const Study& study, const Conduct& conduct, Results& results, int threads,
                   const std::function<void(const SweepProgress&)>& on_progress, bool keep_others = false);

}  // namespace freeplay
