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

/// A list of each run: its table, and the columns of that besides the reference to the run. This is the key
/// `run`; in a list with a view, the integer `id`, and the view shows the list with the key.
struct ListOfRuns {
  const char *table, *columns, *view = nullptr;
};
/// SQL of the table of a list, and of its index.
std::vector<std::string> definitions_of(const ListOfRuns& list);

/// The lists of sweeps. A list of blobs has one row for each run.
inline constexpr ListOfRuns lists_of_runs[] = {
    {"turn_rows", "turn INTEGER, peak REAL", "turns"},
    {"flight_rows", "loss REAL, angle REAL, duration REAL, deceleration REAL, contact TEXT", "flights"},
    {"impact_rows", "angle REAL, approach REAL, impulse REAL, contact TEXT", "impacts"},
    {"measure_rows", "measure TEXT, number INTEGER, t REAL, value REAL", "measures"},
    {"cost_rows", "cpu_s REAL, steps INTEGER, right_hand_sides INTEGER, pivots INTEGER", "costs"},
    {"spectrum_blobs", "amplitude BLOB", "spectra"},
    {"trace_blobs", "angle BLOB, acceleration BLOB, position BLOB", "traces"}};

/// SQL of the view of a list, after CREATE VIEW, for a database with its table.
std::string view_of(const Database& database, const ListOfRuns& list);

/// Likewise of the view `named`: the runs that the study names, with their derived columns if the
/// database has such a table. Other runs remain in the database.
std::string view_of_named(const Database& database);

}  // namespace freeplay
