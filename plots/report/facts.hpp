// What run.json says of the runs of a page, as tables; what warns first; how the results are made again.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "io/files/input_file.hpp"

namespace freeplay::report {

/// A run, and what its page calls it.
struct RunFacts {
  std::string name;
  const JsonFile* json;
};

/// Energy ledgers side by side, statistics of contacts, work and cost: { title, head, rows } each.
nlohmann::json tables(const std::vector<RunFacts>& runs);
/// The tables and paragraphs of a Markdown file that freeplay wrote.
nlohmann::json markdown_tables(const std::filesystem::path& file);
/// { doubtful, text } of each note of the runs, DOUBTFUL ones and endings before the end first.
nlohmann::json notes(const std::vector<RunFacts>& runs);
/// Version, commit, digests and the like of what made a file: { title, head, rows }.
nlohmann::json provenance_table(const std::vector<RunFacts>& files);

/// An argument as a shell takes it.
std::string shell_word(const std::string& text);
/// " --set KEY=VALUE" of each override that a file names.
std::string overrides_of(const JsonFile& file);

}  // namespace freeplay::report
