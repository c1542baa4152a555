// Content of run.json of the runs of a page: tables, notes (warnings first), and the commands that
// reproduce the results.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "io/files/input_file.hpp"

namespace freeplay {
class Table;
}

namespace freeplay::report {

/// A run and its name on the page.
struct RunFacts {
  std::string name;
  const JsonFile* json;
};

/// A value of a file with up to `digits` digits; "–" if there is none.
std::string text_of(const nlohmann::json& value, int digits);

/// A table as { title, head, rows }, from which the script of the page makes its HTML.
nlohmann::json page_table(const std::string& title, const Table& table);

/// Tables of the page: energy ledgers side by side, statistics of contacts, work and
/// cost.
nlohmann::json tables(const std::vector<RunFacts>& runs);
/// The tables and paragraphs of a Markdown file that freeplay wrote.
nlohmann::json markdown_tables(const std::filesystem::path& file);
/// { doubtful, text } of each note of the runs; warnings, and runs that ended early, come first.
nlohmann::json notes(const std::vector<RunFacts>& runs);
/// Table of the provenance of files: version, commit, digests and the like.
nlohmann::json provenance_table(const std::vector<RunFacts>& files);

/// " --set KEY=VALUE" for each override in a file.
std::string overrides_of(const JsonFile& file);

}  // namespace freeplay::report
