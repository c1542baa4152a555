#include "study/store/schema.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "study/store/database.hpp"

namespace freeplay {
namespace {

// Tables of sweeps (also without blobs), attractors and ensembles.
constexpr std::array tables{"runs",    "turn_rows",      "flight_rows", "impact_rows", "measure_rows",
                            "work",    "spectrum_blobs", "trace_blobs", "cost_rows",   "sweeps",
                            "turns",   "flights",        "impacts",     "measures",    "derived",
                            "spectra", "traces",         "costs",       "points",      "ends",
                            "numbers", "exponents"};

constexpr const char* id_of_run = "\"run id\"";

/// Definition of each column of a table.
constexpr const char* columns_of_table =
    "SELECT c.name || ' ' || c.type || iif(c.pk, ' PRIMARY KEY', '') || "
    "iif(EXISTS (SELECT 1 FROM pragma_index_list(?1) AS i JOIN pragma_index_info(i.name) AS k "
    "WHERE i.origin = 'u' AND k.name = c.name), ' UNIQUE', '') || "
    "coalesce((SELECT ' REFERENCES runs(' || f.\"to\" || ') ON DELETE CASCADE' "
    "FROM pragma_foreign_key_list(?1) AS f WHERE f.\"from\" = c.name), '') "
    "FROM pragma_table_xinfo(?1) AS c ORDER BY c.cid";

std::string without_marks(std::string text) {
  std::erase(text, '"');
  return text;
}

std::string text_of_table(const Database& database, const std::string& name) {
  return fmt::format("CREATE TABLE {} ({})", name, fmt::join(database.texts(columns_of_table, name), ", "));
}

/// ", alias.column" for each column of a table except one.
std::string listed(const Database& database, const char* table, const char* alias, const char* except) {
  std::string text;
  for (const auto& column : columns_of(database, table))
    if (column != except) text += fmt::format(", {}.{}", alias, column);
  return text;
}

}  // namespace

std::vector<std::string> columns_of(const Database& database, const std::string& table) {
  const auto texts = database.texts("SELECT sql FROM sqlite_master WHERE type = 'table' AND name = ?", table);
  const auto text = texts.empty() ? std::string() : texts.front();
  std::vector<std::string> columns;
  Database::Statement row(database, fmt::format("PRAGMA table_info({})", table));
  while (row.step()) {
    const auto name = row.text(1), quoted = '"' + name + '"';
    columns.push_back(text.find(quoted) == text.npos ? name : quoted);
  }
  return columns;
}

std::vector<std::string> definitions_of(const ListOfRuns& list) {
  const char* const reference = list.view ? "id" : "run";
  const bool single = std::string_view(list.columns).find("BLOB") != std::string_view::npos;
  std::vector<std::string> sql{fmt::format("CREATE TABLE {} ({} {}REFERENCES runs({}) ON DELETE CASCADE, {})",
                                           list.table, list.view ? "id INTEGER" : "run TEXT",
                                           single ? "PRIMARY KEY " : "", list.view ? id_of_run : "run",
                                           list.columns)};
  if (!single) sql.push_back(fmt::format("CREATE INDEX {0}_{1} ON {0}({1})", list.table, reference));
  return sql;
}

std::string view_of(const Database& database, const ListOfRuns& list) {
  return fmt::format("{} AS SELECT runs.run AS run{} FROM runs JOIN {} AS many ON many.id = runs.\"run id\"",
                     list.view, listed(database, list.table, "many", "id"), list.table);
}

std::string view_of_named(const Database& database) {
  const auto all = listed(database, "runs", "runs", ""), runs = listed(database, "runs", "runs", id_of_run),
             derived = listed(database, "derived", "derived", "run");
  return fmt::format(
      "named AS SELECT {}{} FROM runs{} WHERE runs.run NOT IN (SELECT run FROM work WHERE state = 'kept')",
      runs == all ? "runs.*" : runs.substr(2),  // without the integer: of an earlier version
      derived, derived.empty() ? "" : " LEFT JOIN derived ON derived.run = runs.run");
}

bool is_own(const Database& database, const SchemaObject& object) {
  const auto text = without_marks(object.sql);
  if (std::ranges::any_of(text, [](unsigned char c) { return c < 0x20 || c == 0x7f; })) return false;
  if (object.type == "index")
    return std::ranges::any_of(std::array{"run", "id", "state"}, [&](const char* column) {
      return object.name == fmt::format("{}_{}", object.table, column) &&
             text == fmt::format("CREATE INDEX {} ON {}({})", object.name, object.table, column);
    });
  if (object.table != object.name) return false;
  if (object.type == "table") {
    // A virtual table must not be asked for its columns.
    if (std::ranges::find(tables, object.name) == tables.end() || !text.starts_with("CREATE TABLE "))
      return false;
    const auto own = text_of_table(database, object.name);
    return text == own || text == own + " WITHOUT ROWID";
  }
  const auto is_view = [&](const std::string& own) { return text == without_marks("CREATE VIEW " + own); };
  return object.type == "view" &&
         (is_view(view_of_named(database)) || std::ranges::any_of(lists_of_runs, [&](const auto& list) {
            return is_view(view_of(database, list));
          }));
}

}  // namespace freeplay
