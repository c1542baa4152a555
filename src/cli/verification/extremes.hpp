// `freeplay extremes --random-scenes N`: tests random scenes instead of the map of extreme
// parameters. With --kinds, random scenes with a reference for each row.
#pragma once

#include <filesystem>
#include <string>

namespace freeplay::cli {

/// Options of the random-scene tests.
struct RandomScenesRequest {
  int count = 0, seed = 1;
  int only = -1;              ///< test this scene only and write it to a file; −1: all
  std::string document = {};  ///< folder for random-scenes.md
  /// Of scenes with a reference for each row; empty: the others, all ways.
  std::string kinds = {}, way = {};
  int first = 0;  ///< number of the first scene with a reference for each row
};
/// Exit status 1 if there is a defect. `output`: result folder; empty: the default.
int random_scenes(const RandomScenesRequest& request, const std::string& output);

}  // namespace freeplay::cli
