// Permitted definitions in a database of this program. A database may be of unknown origin, and its
// schema is SQL that SQLite executes: triggers, views, expressions of indexes and defaults. Each
// definition found in a file is therefore parsed as one of the few forms that this program writes,
// and composed again from the program's own text and the names in it:
//
//     CREATE TABLE t (c TYPE [constraint], …) [WITHOUT ROWID]      TYPE: TEXT, REAL, INTEGER, BLOB
//     CREATE INDEX t_c ON t(c)
//     CREATE VIEW v AS SELECT … FROM runs [JOIN …] [WHERE runs.run NOT IN (…)]
//
// for tables, indexes and views of known names. If a definition differs from the composed text in
// any character, the file is refused (study/store/database.hpp). Only composed text is executed,
// never that of the file.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace freeplay {

/// A row of sqlite_master.
struct SchemaObject {
  std::string type, name, table, sql;
  auto operator<=>(const SchemaObject&) const = default;
};

/// A definition in this program's text.
struct Definition {
  std::string text;                  ///< one SQL statement
  std::vector<std::string> columns;  ///< of a table, in SQL: a name, or "a name"
};

/// The definition of an object; nullopt if no version of this program creates it.
std::optional<Definition> own_definition(const SchemaObject& object);

}  // namespace freeplay
