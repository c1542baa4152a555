#include "study/store/run_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "io/files/output_file.hpp"

namespace freeplay {
namespace {

using Statement = Database::Statement;

std::size_t count(const Database& database, const std::string& rows) {
  return static_cast<std::size_t>(database.number_of("SELECT count(*) FROM " + rows));
}

}  // namespace

std::string run_key(Identity shared, const std::string& lines) {
  shared.given += lines;
  return shared.digest();
}
std::string run_key(Identity all_starts, int start) {
  return run_key(std::move(all_starts), fmt::format("start = {}\n", start));
}

WorkList::WorkList(const Database& database, const FolderLock& lock, const std::vector<std::string>& runs,
                   Earlier earlier)
    : database_(database), lock_(lock) {
  database_.execute("CREATE TEMP TABLE IF NOT EXISTS asked (run TEXT PRIMARY KEY)");
  Database::Transaction whole(database_);
  database_.execute("DELETE FROM asked");
  {
    Statement s(database_, "INSERT OR IGNORE INTO asked VALUES (?)");
    for (const auto& run : runs) s.put(run);
  }
  lost_ += release(lock_.slot());  // left by an earlier process with this slot
  release_claims_of_ended_processes();
  if (count(database_, "sweeps") > 0)
    require_the_others_list();
  else
    make_list(runs, earlier);
  database_.execute("INSERT INTO sweeps VALUES (?)", static_cast<long>(lock_.slot()));
  found_ = count(database_, "asked WHERE run IN (SELECT run FROM runs)");
  marked_ = marked_done();
  kept_ = count(database_, "work WHERE state = 'kept'");
  whole.commit();
}

void WorkList::release_claims_of_ended_processes() {
  for (const long slot : database_.list<long, long>(
           "SELECT seat FROM sweeps UNION SELECT seat FROM work WHERE state = 'claimed'"))
    if (!lock_.taken(static_cast<int>(slot))) lost_ += release(slot);
}

std::size_t WorkList::release(long slot) {
  const auto claimed = count(database_, fmt::format("work WHERE state = 'claimed' AND seat = {}", slot));
  database_.execute("UPDATE work SET state = 'open', seat = NULL WHERE state = 'claimed' AND seat = ?", slot);
  database_.execute("DELETE FROM sweeps WHERE seat = ?", slot);
  return claimed;
}

void WorkList::require_the_others_list() const {
  const char* named = "SELECT run FROM work WHERE state != 'kept'";
  if (count(database_, fmt::format("asked WHERE run NOT IN ({})", named)) +
          count(database_, fmt::format("({}) WHERE run NOT IN (SELECT run FROM asked)", named)) >
      0)
    throw OutputError(fmt::format(
        "{}: another form of this study is running in this folder ({}); wait for its end, or give another "
        "folder with -o",
        database_.file().string(), lock_.others()));
}

void WorkList::make_list(const std::vector<std::string>& runs, Earlier earlier) {
  const std::string others = "run NOT IN (SELECT run FROM asked)";
  const char* state = earlier == Earlier::kept ? "kept" : "done";
  database_.execute(fmt::format("DELETE FROM work WHERE {} AND run NOT IN (SELECT run FROM runs)", others));
  if (earlier == Earlier::kept) database_.execute("UPDATE work SET state = 'kept' WHERE " + others);
  database_.execute(
      fmt::format("INSERT OR IGNORE INTO work SELECT run, '{}', NULL FROM runs WHERE {}", state, others));
  Statement s(database_,  // in the order of the study
              "INSERT INTO work VALUES (?1, CASE WHEN EXISTS (SELECT 1 FROM runs WHERE run = ?1) THEN 'done' "
              "ELSE 'open' END, NULL) ON CONFLICT DO UPDATE SET state = excluded.state, seat = NULL");
  for (const auto& run : runs) s.put(run);
}

WorkList::~WorkList() {
  try {
    Database::Transaction whole(database_);
    release(lock_.slot());
    whole.commit();
  } catch (const OutputError&) {
    // The claims end with this process.
  }
}

std::vector<std::string> WorkList::claim(int most) {
  Database::Transaction whole(database_);
  const auto open = [&] {
    return database_.texts("SELECT run FROM work WHERE state = 'open' LIMIT ?", static_cast<long>(most));
  };
  auto runs = open();
  if (runs.empty()) {
    release_claims_of_ended_processes();
    runs = open();
  }
  Statement claimed(database_, "UPDATE work SET state = 'claimed', seat = ? WHERE run = ?");
  for (const auto& run : runs) claimed.put(static_cast<long>(lock_.slot()), run);
  whole.commit();
  return runs;
}

std::size_t WorkList::marked_done() const { return count(database_, "work WHERE state = 'done'"); }

// Uses the index of states; a condition on the list of runs would scan it.
std::size_t WorkList::done_now() const {
  const auto alone = database_.alone();
  return found_ + marked_done() - marked_;
}

bool WorkList::ended() const {
  return database_.number_of("SELECT EXISTS (SELECT 1 FROM work WHERE state IN ('open', 'claimed'))") == 0;
}

RunStore::RunStore(const std::filesystem::path& file, Database::Access access, const StoreForm& form,
                   StopToken stop)
    : database_(file, access, stop) {
  std::vector<std::string> definitions{fmt::format("CREATE TABLE runs ({})", form.columns)};
  for (const auto& list : form.lists)
    std::ranges::move(definitions_of(list), std::back_inserter(definitions));
  if (form.divided) std::ranges::copy(WorkList::definitions, std::back_inserter(definitions));
  std::optional<Database::Transaction> whole;  // two processes may open a new file at the same time
  if (access == Database::Access::write) whole.emplace(database_);
  const auto there = database_.schema();
  if (there.empty() && whole) {
    database_.execute(fmt::format("PRAGMA user_version = {}", form.kind));
    for (const auto& definition : definitions) database_.execute(definition);
  } else {
    if (const auto kind = database_.kind(); kind != form.kind)
      throw OutputError(fmt::format(
          "{}: its runs were stored by {} version or another verb, in incompatible tables, and cannot be "
          "used: give another folder with -o, or move the file",
          file.string(), kind < form.kind ? "an earlier" : "a later"));
    for (const auto& definition : definitions)
      if (std::ranges::find(there, definition, &SchemaObject::sql) == there.end())
        throw OutputError(fmt::format(
            "{}: contains another study, or one of another version; give another folder with -o, or remove "
            "it",
            file.string()));
  }
  if (whole) whole->commit();
}

}  // namespace freeplay
