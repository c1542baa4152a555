#include "study/attractors/attractor_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "mechanism/magnitude.hpp"
#include "simulation/section.hpp"

namespace freeplay {
namespace {

using Statement = Database::Statement;

constexpr double greatest_value = 1e45;  // as of forces, the greatest of all plausible ranges

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

bool AttractorStore::find(const std::string& key, const Expected& expected, SettledRun& run) const {
  Statement s(database_, "SELECT failure, doubt, t_end FROM runs WHERE run = ?");
  s.bind(key);
  if (!s.step()) return false;
  const auto require = [&](bool holds, const char* what) {
    if (!holds) database_.refuse(fmt::format("{} of run {:.12} are wrong; it is damaged", what, key));
  };
  run.failure = s.text(0);
  run.doubt = s.text(1);
  run.end = {.t = s.number(2), .q = {}, .v = {}, .z = {}};
  // A run ends at the last of its steps, which rounding may move.
  const double latest = expected.until * (1 + 1e-9);
  require(run.end.t >= 0 && run.end.t <= latest &&
              (!run.failure.empty() || run.end.t >= expected.until * (1 - 1e-9)),
          "the times");
  const auto width = expected.columns.size();
  Statement points(database_, "SELECT point, name, t, value FROM points WHERE run = ? ORDER BY rowid");
  points.bind(key);
  while (points.step()) {
    const auto column = run.rows.size() % width, point = run.rows.size() / width;
    require(point < SectionPoints::most && points.whole(0) == static_cast<long>(point) &&
                points.text(1) == expected.columns[column].name,
            "the points");
    const double t = points.number(2);
    if (column == 0) {
      require(t >= (run.t.empty() ? 0 : run.t.back()) && t <= latest, "the times of points");
      run.t.push_back(t);
    }
    require(t == run.t.back(), "the times of points");
    run.rows.push_back(points.number(3));
    require(!(std::abs(run.rows.back()) > greatest_value), "the points");
  }
  require(run.rows.size() == run.t.size() * width, "the points");
  Statement ends(database_, "SELECT part, place, value FROM ends WHERE run = ? ORDER BY rowid");
  ends.bind(key);
  const std::tuple<const char*, std::vector<double>&, std::size_t, double> parts[] = {
      {"q", run.end.q, expected.coordinates, magnitude_of("m")->greatest},
      {"v", run.end.v, expected.coordinates, magnitude_of("m/s")->greatest},
      {"z", run.end.z, expected.states, greatest_value}};
  for (const auto& [name, list, count, greatest] : parts)
    for (std::size_t i = 0; i < count; ++i) {
      require(ends.step() && ends.text(0) == name && ends.whole(1) == static_cast<long>(i), "the end values");
      list.push_back(ends.number(2));
      require(std::abs(list.back()) <= greatest, "the end values");
    }
  require(!ends.step(), "the end values");
  return true;
}

void AttractorStore::store(const std::string& key, const SettledRun& run,
                           const std::vector<NamedColumn>& columns) {
  Database::Transaction whole(database_);
  database_.execute("INSERT INTO runs VALUES (?, ?, ?, ?, ?, ?, ?)", key, run.branch, run.values[0],
                    run.values.size() > 1 ? run.values[1] : std::nan(""), run.failure, run.doubt, run.end.t);
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
  const auto found = database_.rows(
      "SELECT value, error, reason FROM exponents WHERE run = ? AND periods = ?",
      [](const Statement& s) {
        return AttractorExponent{s.number(0), s.number(1), s.text(2)};
      },
      key, periods);
  return found.empty() ? std::nullopt : std::optional(found.front());
}

void AttractorStore::store_exponent(const std::string& key, long periods, const AttractorExponent& e) {
  database_.execute("INSERT INTO exponents VALUES (?, ?, ?, ?, ?)", key, periods, e.value, e.error, e.reason);
}

}  // namespace freeplay
