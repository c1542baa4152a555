// Summaries of many random scenes: tables by method, refusals by kind, and the page of docs/.
#pragma once

#include <string>
#include <vector>

#include "verification/random_scenes/runner.hpp"

namespace freeplay::verification::random_scenes {

/// The reason of a refusal without its numbers and names, so that equal ones can be counted.
std::string kind_of_refusal(const std::string& reason);
/// The same in one line that justifies it; empty for one that nobody has looked at.
std::string justification(const std::string& kind);

/// Outcomes by way as a table in Markdown, which a terminal shows as well.
std::string table_of(const std::vector<Row>& rows, Suite suite);
/// Of scenes that are known at every row, defects by kind and way.
std::string defects_by_kind(const std::vector<Row>& rows);
/// Of the others, refusals by kind, and what the notes of runs outside a bound say.
std::string refusals_of(const std::vector<Row>& rows);
std::string noted_of(const std::vector<Row>& rows);
/// docs/strangers.md.
std::string page_of(const std::vector<Row>& rows, std::uint64_t seed, int count, double seconds);

}  // namespace freeplay::verification::random_scenes
