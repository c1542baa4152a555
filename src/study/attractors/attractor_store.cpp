#include "study/attractors/attractor_store.hpp"

#include <fmt/format.h>

#include <cmath>

#include "io/files/output_file.hpp"

namespace freeplay {
namespace {

using Statement = Database::Statement;

constexpr int kind_of_file = 2;  // user_version; 1 is a sweep's

}  // namespace

AttractorStore::AttractorStore(const std::filesystem::path& file, StopToken stop)
    : database_(file, Database::Access::write, stop) {
  Database::Transaction whole(database_);
  Statement existing(database_, "SELECT count(*) FROM sqlite_master");
  existing.step();
  if (existing.whole(0) > 0 && database_.kind() != kind_of_file)
    throw OutputError(fmt::format(
        "{}: is no file of attractors of this freeplay; give another folder with -o, or move it away",
        file.string()));
  database_.execute(fmt::format("PRAGMA user_version = {}", kind_of_file));
  database_.execute(
      "CREATE TABLE IF NOT EXISTS runs (run TEXT PRIMARY KEY, branch TEXT, x REAL, y REAL, failure TEXT, doubt TEXT, "
      "t_end REAL)");
  const char* of_run = "run TEXT REFERENCES runs(run) ON DELETE CASCADE";
  database_.execute(fmt::format(
      "CREATE TABLE IF NOT EXISTS points ({}, point INTEGER, t REAL, name TEXT, value REAL)", of_run));
  database_.execute(
      fmt::format("CREATE TABLE IF NOT EXISTS ends ({}, part TEXT, place INTEGER, value REAL)", of_run));
  for (const char* name : {"points", "ends"})
    database_.execute(fmt::format("CREATE INDEX IF NOT EXISTS {0}_run ON {0}(run)", name));
  whole.commit();
}

bool AttractorStore::find(const std::string& key, SettledRun& run) const {
  Statement s(database_, "SELECT failure, doubt, t_end FROM runs WHERE run = ?");
  s.bind(key);
  if (!s.step()) return false;
  run.failure = s.text(0);
  run.doubt = s.text(1);
  run.end = {.t = s.number(2), .q = {}, .v = {}, .z = {}};
  Statement points(database_, "SELECT point, t, value FROM points WHERE run = ? ORDER BY rowid");
  points.bind(key);
  for (long last = -1; points.step(); last = points.whole(0)) {
    if (points.whole(0) != last) run.t.push_back(points.number(1));
    run.rows.push_back(points.number(2));
  }
  Statement ends(database_, "SELECT part, value FROM ends WHERE run = ? ORDER BY rowid");
  ends.bind(key);
  while (ends.step()) {
    const auto part = ends.text(0);
    (part == "q" ? run.end.q : part == "v" ? run.end.v : run.end.z).push_back(ends.number(1));
  }
  return true;
}

void AttractorStore::store(const std::string& key, const SettledRun& run,
                           const std::vector<NamedColumn>& columns) {
  Database::Transaction whole(database_);
  Statement(database_, "INSERT INTO runs VALUES (?, ?, ?, ?, ?, ?, ?)")
      .bind(key)
      .bind(run.branch)
      .bind(run.values[0])
      .bind(run.values.size() > 1 ? run.values[1] : std::nan(""))
      .bind(run.failure)
      .bind(run.doubt)
      .bind(run.end.t)
      .step();
  Statement points(database_, "INSERT INTO points VALUES (?, ?, ?, ?, ?)");
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    const auto point = i / columns.size();
    points.bind(key)
        .bind(static_cast<long>(point))
        .bind(run.t[point])
        .bind(columns[i % columns.size()].name)
        .bind(run.rows[i]);
    points.again();
  }
  Statement ends(database_, "INSERT INTO ends VALUES (?, ?, ?, ?)");
  const auto put = [&](const char* part, const std::vector<double>& list) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      ends.bind(key).bind(std::string(part)).bind(static_cast<long>(i)).bind(list[i]);
      ends.again();
    }
  };
  put("q", run.end.q);
  put("v", run.end.v);
  put("z", run.end.z);
  whole.commit();
}

}  // namespace freeplay
