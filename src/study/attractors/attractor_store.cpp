#include "study/attractors/attractor_store.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

using Statement = Database::Statement;

const StoreForm form{
    2,
    {"CREATE TABLE runs (run TEXT PRIMARY KEY, branch TEXT, x REAL, y REAL, failure TEXT, doubt TEXT, t_end REAL)",
     "CREATE TABLE points (run TEXT REFERENCES runs(run) ON DELETE CASCADE, point INTEGER, t REAL, name TEXT, "
     "value REAL)",
     "CREATE INDEX points_run ON points(run)",
     "CREATE TABLE ends (run TEXT REFERENCES runs(run) ON DELETE CASCADE, part TEXT, place INTEGER, value REAL)",
     "CREATE INDEX ends_run ON ends(run)"}};

constexpr const char* exponent_definitions[] = {
    "CREATE TABLE exponents (run TEXT REFERENCES runs(run) ON DELETE CASCADE, periods INTEGER, value REAL, "
    "error REAL, reason TEXT)",
    "CREATE INDEX exponents_run ON exponents(run)"};

}  // namespace

AttractorStore::AttractorStore(const std::filesystem::path& file, StopToken stop)
    : RunStore(file, Database::Access::write, form, stop) {}

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
      .put(key, run.branch, run.values[0], run.values.size() > 1 ? run.values[1] : std::nan(""), run.failure,
           run.doubt, run.end.t);
  Statement points(database_, "INSERT INTO points VALUES (?, ?, ?, ?, ?)");
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    const auto point = i / columns.size();
    points.put(key, static_cast<long>(point), run.t[point], columns[i % columns.size()].name, run.rows[i]);
  }
  Statement ends(database_, "INSERT INTO ends VALUES (?, ?, ?, ?)");
  const auto put = [&](const std::string& part, const std::vector<double>& list) {
    for (std::size_t i = 0; i < list.size(); ++i) ends.put(key, part, static_cast<long>(i), list[i]);
  };
  put("q", run.end.q);
  put("v", run.end.v);
  put("z", run.end.z);
  whole.commit();
}

void AttractorStore::begin_exponents() {
  Database::Transaction whole(database_);  // two processes may begin at the same time
  const auto there = database_.schema();
  for (const auto* definition : exponent_definitions)
    if (std::ranges::find(there, definition, &SchemaObject::sql) == there.end())
      database_.execute(definition);
  whole.commit();
}

std::optional<AttractorExponent> AttractorStore::find_exponent(const std::string& key, long periods) const {
  Statement s(database_, "SELECT value, error, reason FROM exponents WHERE run = ? AND periods = ?");
  s.bind(key).bind(periods);
  if (!s.step()) return {};
  return AttractorExponent{s.number(0), s.number(1), s.text(2)};
}

void AttractorStore::store_exponent(const std::string& key, long periods, const AttractorExponent& e) {
  Statement(database_, "INSERT INTO exponents VALUES (?, ?, ?, ?, ?)")
      .put(key, periods, e.value, e.error, e.reason);
}

}  // namespace freeplay
