// What the databases of this program are made of. A database may come from anybody, and its schema is text that SQLite runs: a
// trigger, a view, an expression of an index or a default. So each definition found in a file is parsed by the few forms that this
// program writes and composed anew from its own words and the names in it,
//
//     CREATE TABLE t (c TYPE [constraint], …) [WITHOUT ROWID]      TYPE: TEXT, REAL, INTEGER, BLOB
//     CREATE INDEX t_c ON t(c)
//     CREATE VIEW v AS SELECT … FROM runs [JOIN …] [WHERE runs.run NOT IN (…)]
//
// for tables, indexes and views of known names. A definition that is not letter by letter what is composed is no definition of this
// program's: the file is refused (study/store/database.hpp). What is executed is the composed text, never the file's.
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

/// A definition in this program's words.
struct Definition {
  std::string text;                  ///< one SQL statement
  std::vector<std::string> columns;  ///< of a table, as SQL has them: a name, or "a name"
};

/// None where this program makes no such object, in this version or an earlier one.
std::optional<Definition> own_definition(const SchemaObject& object);

}  // namespace freeplay
