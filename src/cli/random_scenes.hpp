// freeplay extremes --strangers N: random scenes in place of the map; with --kinds those that are known at every row.
#pragma once

#include <filesystem>
#include <string>

namespace freeplay::cli {

struct RandomScenesRequest {
  int count = 0, seed = 1;
  int only = -1;                     ///< judge this one alone and write its scene; −1: all
  std::string document = {};         ///< folder for random-scenes.md
  std::string kinds = {}, way = {};  ///< of scenes that are known at every row; empty: the others, all ways
  int first = 0;                     ///< of those that are known at every row
};
/// Exit status 1 where there is a defect. `output`: result folder, empty: the usual one.
int random_scenes(const RandomScenesRequest& request, const std::string& output);

}  // namespace freeplay::cli
