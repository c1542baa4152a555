// Assesses many random scenes on all cores, each in its own process, so that a crash or a hang is
// an outcome too.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "verification/random_scenes/scene.hpp"

namespace freeplay::verification::random_scenes {

/// A scene and a method.
struct Row {
  int index = 0;
  std::string kind, way;
  Verdict verdict;
};

struct Request {
  std::uint64_t seed = 1;
  int first = 0, count = 0;
  std::string kinds = {};  ///< as in `draw`
  std::string way = {};    ///< only this one; empty: all
};

/// One scene by every method that has a model of it.
std::vector<Row> judge_apart(const RandomScene& scene, const std::string& only_way = {});

/// Scenes first to first + count − 1, in the order of index and method. `seen` receives the share
/// that is done. Where every row is known, rows are appended to judgements.csv of the folder as
/// they come, existing ones are not assessed again, and a failing scene is written to
/// failing/KIND-INDEX-WAY.toml.
std::vector<Row> judge_all(const Request& request, const std::filesystem::path& folder,
                           const std::function<void(double)>& seen = {});

}  // namespace freeplay::verification::random_scenes
