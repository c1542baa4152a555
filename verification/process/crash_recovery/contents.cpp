#include "verification/process/crash_recovery/campaign.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "verification/support/support.hpp"
#include "verification/support/texts.hpp"

namespace freeplay::killed {
namespace {

/// Removes keys that depend on the cost of a run. A verdict states the ratio of CPU times.
void remove_costs(nlohmann::json& j) {
  if (j.is_object())
    for (const char* key : {"cost", "cpu_s", "cpu_least_s", "cpu_greatest_s", "verdict"}) j.erase(key);
  if (j.is_structured())
    for (auto& child : j) remove_costs(child);
}

/// Lines without those on costs; of tradeoff.csv without its last three columns.
std::string lines_in(const Path& file) {
  std::string text;
  for (auto line : test::lines_of(test::file_text(file))) {
    if (line.find("CPU") != line.npos) continue;
    if (file.filename() == "tradeoff.csv")
      for (int i = 0; i < 3; ++i) line.resize(line.rfind(','));
    text += line + "\n";
  }
  return text;
}

std::string result_of(const Path& file) {
  if (file.extension() != ".json") return lines_in(file);
  auto document = nlohmann::json::parse(test::file_text(file), nullptr, false);
  if (document.is_discarded()) return "no JSON";
  remove_costs(document);
  return document.dump();
}

bool half(const Path& file) { return file.extension() == ".partial" || file.filename() == "run.checkpoint"; }

}  // namespace

Contents results_in(const Path& folder) {
  Contents contents;
  std::error_code none;
  for (auto it = std::filesystem::recursive_directory_iterator(folder, none);
       it != std::filesystem::recursive_directory_iterator(); ++it) {
    const auto name = it->path().filename().string();
    if (it->is_directory() && (name.starts_with(".") || name == "figures")) it.disable_recursion_pending();
    if (!it->is_regular_file() || name.starts_with(".") || half(it->path())) continue;
    if (name.find(".db") != name.npos) continue;
    contents[it->path().lexically_relative(folder).string()] = result_of(it->path());
  }
  return contents;
}

Contents runs_in(const Path& database) {
  Contents contents;
  if (!std::filesystem::exists(database)) return contents;
  sqlite3* db = nullptr;
  if (sqlite3_open_v2(database.c_str(), &db, SQLITE_OPEN_READWRITE, nullptr) != SQLITE_OK)
    throw std::runtime_error(database.string() + ": cannot be opened");
  sqlite3_busy_timeout(db, 60000);
  const auto row = [](void* to, int columns, char** values, char** names) {
    auto& text = (*static_cast<Contents*>(to))[values[0]];
    for (int i = 1; i < columns; ++i)
      if (std::string_view(names[i]) != "run id") text += fmt::format("{}|", values[i] ? values[i] : "-");
    text += '\n';
    return 0;
  };
  const auto ask = [&](const std::string& what) { sqlite3_exec(db, what.c_str(), row, &contents, nullptr); };
  // A program killed while it made the file may not have created its tables; databases of studies
  // and of attractors have different ones.
  ask("BEGIN");
  ask("SELECT * FROM runs");
  for (const char* table : {"turns", "flights", "impacts", "measures", "points", "ends"})
    ask(fmt::format("SELECT run, '{0}', * FROM {0} ORDER BY rowid", table));
  ask("SELECT run, hex(amplitude) FROM spectra");
  ask("SELECT run, hex(angle), hex(acceleration), hex(position) FROM traces");
  ask("SELECT run, steps, right_hand_sides, pivots FROM costs");
  ask("COMMIT");
  sqlite3_close(db);
  return contents;
}

std::string leftovers_in(const Path& folder) {
  std::string names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const auto name = entry.path().filename().string();
    if (name.starts_with(".") || half(entry.path()) || name.ends_with("-wal") || name.ends_with("-shm"))
      names += entry.path().lexically_relative(folder).string() + " ";
  }
  return names;
}

}  // namespace freeplay::killed
