// Assesses many random scenes on all cores, each in its own process, so that a crash or a hang is
// an outcome too.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "values/table.hpp"
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

// Summaries of many random scenes: tables by method, refusals by kind, and the page of docs/.

/// The reason of a refusal without its numbers and names, so that equal ones can be counted.
std::string kind_of_refusal(const std::string& reason);
/// The justification of a refusal in one line; empty for one that has not been reviewed.
std::string justification(const std::string& kind);

/// Outcomes by method as a table in Markdown, which a terminal shows as well; then, for scenes with a
/// reference for every row (random_scenes.md), defects by kind and method, for the others refusals by
/// kind and the notes of runs outside a bound.
std::string summary_of(const std::vector<Row>& rows, Suite suite);
/// strangers.csv.
Table table_of(const std::vector<Row>& rows, std::uint64_t seed);
/// docs/verification/random-scenes.md.
std::string page_of(const std::vector<Row>& rows, std::uint64_t seed, int count, double seconds);

}  // namespace freeplay::verification::random_scenes
