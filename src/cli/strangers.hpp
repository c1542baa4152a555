// freeplay extremes --strangers: scenes that nobody designed.
#pragma once

#include <filesystem>
#include <string>

namespace freeplay::cli {

struct StrangersRequest {
  int count = 0, seed = 1;
  int only = -1;         ///< judge this one alone and write its scene; −1: all
  std::string document;  ///< folder for strangers.md
  /// Kinds of verification/random_scenes in place of these, with the first index and the only way; empty: none.
  std::string kinds = {}, way = {};
  int first = 0;
};
/// Exit status 1 where there is a defect.
int strangers(const StrangersRequest& request, const std::filesystem::path& folder);

}  // namespace freeplay::cli
