// A study checked whole before anything of its results is touched.
#pragma once

#include <string>
#include <vector>

#include "study/runs/case_run.hpp"

namespace freeplay {

/// A run and the name that it is stored by.
struct PlannedRun {
  std::string key;
  Case what;
};

/// All runs of a study, each once. Every scene that it makes is read, compiled and assembled, and has the joint and the
/// instruments that the study names. Throws SceneError. A stop that is asked for ends it early: the list is not whole then.
std::vector<PlannedRun> plan(const Study& study, const Conduct& conduct);

}  // namespace freeplay
