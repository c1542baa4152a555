// Permitted definitions in a database of this program. A database may be of unknown origin, and its
// schema is SQL that SQLite executes: triggers, views, expressions of indexes and defaults. A
// definition is composed again from the names that SQLite reports (pragma table_xinfo):
//
//     CREATE TABLE t (c TYPE [constraint], …) [WITHOUT ROWID]
//     CREATE INDEX t_c ON t(c)
//     CREATE VIEW v AS …                 a list of the runs, or the runs that the study names
//
// A file with any other text, apart from quotation marks, is refused (study/store/database.hpp).
#pragma once

#include <string>
#include <vector>

namespace freeplay {

class Database;

/// A row of sqlite_master.
struct SchemaObject {
  std::string type, name, table, sql;
  auto operator<=>(const SchemaObject&) const = default;
};

/// Whether this or an earlier version of the program creates the object of a database.
bool is_own(const Database& database, const SchemaObject& object);

/// Columns of a table in SQL: a name, or "a name"; none if there is no such table.
std::vector<std::string> columns_of(const Database& database, const std::string& table);

/// A list of each run: its table, which refers to the run by the integer `id`, the view that shows
/// it with the key of the run, and its own columns.
struct ListOfRuns {
  const char *table, *view, *columns;
};
inline constexpr ListOfRuns lists_of_runs[] = {
    {"turn_rows", "turns", "turn INTEGER, peak REAL"},
    {"flight_rows", "flights", "loss REAL, angle REAL, duration REAL, deceleration REAL, contact TEXT"},
    {"impact_rows", "impacts", "angle REAL, approach REAL, impulse REAL, contact TEXT"},
    {"measure_rows", "measures", "measure TEXT, number INTEGER, t REAL, value REAL"},
    {"cost_rows", "costs", "cpu_s REAL, steps INTEGER, right_hand_sides INTEGER, pivots INTEGER"},
    {"spectrum_blobs", "spectra", "amplitude BLOB"},
    {"trace_blobs", "traces", "angle BLOB, acceleration BLOB, position BLOB"}};

/// SQL of the view of a list, after CREATE VIEW, for a database with its table.
std::string view_of(const Database& database, const ListOfRuns& list);

/// Likewise of the view `named`: the runs that the study names, with their derived columns if the
/// database has such a table. Other runs remain in the database.
std::string view_of_named(const Database& database);

}  // namespace freeplay
