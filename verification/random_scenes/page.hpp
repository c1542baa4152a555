// Summaries of many random scenes: tables by method, refusals by kind, and the page of docs/.
#pragma once

#include <string>
#include <vector>

#include "values/table.hpp"
#include "verification/random_scenes/runner.hpp"

namespace freeplay::verification::random_scenes {

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
