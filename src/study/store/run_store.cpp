#include "study/store/run_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "io/files/output_file.hpp"

namespace freeplay {

RunStore::RunStore(const std::filesystem::path& file, Database::Access access, const StoreForm& form,
                   StopToken stop)
    : database_(file, access, stop) {
  std::optional<Database::Transaction> whole;  // two processes may open a new file at the same time
  if (access == Database::Access::write) whole.emplace(database_);
  const auto there = database_.schema();
  if (there.empty() && whole) {
    database_.execute(fmt::format("PRAGMA user_version = {}", form.kind));
    for (const auto& definition : form.definitions) database_.execute(definition);
  } else {
    if (const auto kind = database_.kind(); kind != form.kind)
      throw OutputError(fmt::format(
          "{}: its runs were stored by {} version or another verb, in incompatible tables, and cannot be "
          "used: give another folder with -o, or move the file",
          file.string(), kind < form.kind ? "an earlier" : "a later"));
    for (const auto& definition : form.definitions)
      if (std::ranges::find(there, definition, &SchemaObject::sql) == there.end())
        throw OutputError(fmt::format(
            "{}: contains another study, or one of another version; give another folder with -o, or remove "
            "it",
            file.string()));
  }
  if (whole) whole->commit();
}

}  // namespace freeplay
