// Planning of a study: all its runs are made and checked before any result is changed. The list is
// the input of study/sweep/sweep.hpp.
#pragma once

#include <string>
#include <vector>

#include "study/runs/case_run.hpp"

namespace freeplay {

/// A run and its key in the database.
struct PlannedRun {
  std::string key;
  Case what;
};

/// All runs of a study, without duplicates. Reads, compiles and assembles each scene, and checks
/// that it has the joints and instruments that the study names, in `threads` threads (0: all cores).
/// Throws the SceneError of the first wrong case. A stop request ends the planning early; the list is
/// then incomplete.
std::vector<PlannedRun> plan(const Study& study, const Conduct& conduct, int threads = 0);

}  // namespace freeplay
