// freeplay extremes --strangers: scenes that nobody designed.
#pragma once

#include <filesystem>
#include <string>

namespace freeplay::cli {

struct StrangersRequest {
  int count = 0, seed = 1;
  int only = -1;         ///< judge this one alone and write its scene; −1: all
  std::string document;  ///< folder for strangers.md
};
/// Exit status 1 where there is a defect.
int strangers(const StrangersRequest& request, const std::filesystem::path& folder);

}  // namespace freeplay::cli
