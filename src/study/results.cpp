#include "study/results.hpp"

#include <fmt/format.h>

#include <cmath>

#include "io/output_file.hpp"
#include "study/work_list.hpp"

namespace freeplay {
namespace {

/// What the keys in a file are made from, in its user_version. 0: the commit and a list of fields, as before runs
/// had an identity; 1: the digest of the identity.
constexpr int kind_of_keys = 1;

using Statement = Database::Statement;

/// A run that the study does not name any more stays, and is left out of what is made of the others. `derived`: further columns.
void make_view(const Database& database, const std::string& derived) {
  database.execute(
      fmt::format("CREATE VIEW named AS SELECT runs.*{} FROM runs{} WHERE runs.run NOT IN "
                  "(SELECT run FROM work WHERE state = 'kept')",
                  derived, derived.empty() ? "" : " LEFT JOIN derived ON derived.run = runs.run"));
}

}  // namespace

Results::Results(const std::filesystem::path& file, const Study& study, StopToken stop)
    : database_(file, stop), axes_(study.axes.size()) {
  for (const auto& m : study.measures) measures_.push_back(m.name);
  Database::Transaction whole(database_);  // two processes may open a new file at a time
  const bool fresh = require_own_tables(study);
  WorkList::make_table(database_);
  if (fresh) make_view(database_, "");
  whole.commit();
}

bool Results::require_own_tables(const Study& study) {
  std::string columns;
  for (const auto& axis : study.axes) columns += fmt::format("\"{}\" REAL, ", axis.name);
  for (const auto& name : TurnMetrics::names()) columns += fmt::format("{} REAL, ", name);
  for (const auto& measure : study.measures) columns += fmt::format("\"{}\" REAL, ", measure.name);
  const auto table = fmt::format(
      "CREATE TABLE runs (run TEXT PRIMARY KEY, variant TEXT, formulation TEXT, start INTEGER, {}"
      "status TEXT, reason TEXT)",
      columns);
  Statement existing(database_, "SELECT sql FROM sqlite_master WHERE name = 'runs'");
  if (existing.step()) {
    const auto& file = database_.file().string();
    Statement kind(database_, "PRAGMA user_version");
    if (kind.step() && kind.number(0) != kind_of_keys)
      throw OutputError(
          fmt::format("{}: its runs were stored by {} freeplay, by keys that do not say what this one's "
                      "do; they stay as they "
                      "are, and none is used: give another folder with -o, or move the file away",
                      file, kind.number(0) < kind_of_keys ? "an earlier" : "a later"));
    Statement parts(database_, "SELECT 1 FROM sqlite_master WHERE name = 'measures'");
    if (existing.text(0) != table || !parts.step())
      throw OutputError(fmt::format(
          "{}: holds another study, or one of another version; give another folder with -o, or remove it",
          file));
    return false;
  }
  const char* of_run = "run TEXT REFERENCES runs(run) ON DELETE CASCADE";
  const auto make = [&](const std::string& sql) { database_.execute(sql); };
  make(fmt::format("PRAGMA user_version = {}", kind_of_keys));
  make(table);
  make(fmt::format("CREATE TABLE turns ({}, turn INTEGER, peak REAL)", of_run));
  make(fmt::format(
      "CREATE TABLE flights ({}, loss REAL, angle REAL, duration REAL, deceleration REAL, contact TEXT)",
      of_run));
  make(fmt::format("CREATE TABLE impacts ({}, angle REAL, approach REAL, impulse REAL, contact TEXT)",
                   of_run));
  make(fmt::format("CREATE TABLE measures ({}, measure TEXT, number INTEGER, t REAL, value REAL)", of_run));
  make(fmt::format("CREATE TABLE spectra ({}, harmonic INTEGER, amplitude REAL)", of_run));
  make(fmt::format("CREATE TABLE traces ({}, angle REAL, acceleration REAL, position REAL)", of_run));
  make(fmt::format(
      "CREATE TABLE costs ({}, cpu_s REAL, steps INTEGER, right_hand_sides INTEGER, pivots INTEGER)",
      of_run));
  for (const char* name : {"turns", "flights", "impacts", "measures", "spectra", "traces", "costs"})
    make(fmt::format("CREATE INDEX {0}_run ON {0}(run)", name));
  return true;
}

std::set<std::string> Results::keys() const {
  std::set<std::string> keys;
  Statement s(database_, "SELECT run FROM runs");
  while (s.step()) keys.insert(s.text(0));
  return keys;
}

void Results::store(const std::string& key, const Case& one, const CaseResult& r) {
  Database::Transaction whole(database_);
  const auto& m = r.metrics;
  std::string marks = "?, ?, ?, ?";
  for (std::size_t i = 0; i < axes_ + TurnMetrics::count + measures_.size() + 2; ++i) marks += ", ?";
  const bool finished = r.ending.status == Ending::Status::finished;
  {
    Statement s(database_, "INSERT OR REPLACE INTO runs VALUES (" + marks + ")");
    s.bind(key).bind(one.variant).bind(one.formulation).bind(static_cast<long>(one.start));
    for (double x : one.values) s.bind(x);
    for (double x : m.value) s.bind(finished && std::isfinite(x) ? x : std::nan(""));
    for (std::size_t i = 0; i < measures_.size(); ++i) {
      const double x = finished ? r.measured[i].value : std::nan("");
      s.bind(std::isfinite(x) ? x : std::nan(""));
    }
    auto reason = r.ending.reason;
    for (const auto& note : r.notes)
      if (finished && note.starts_with("DOUBTFUL")) reason += (reason.empty() ? "" : "; ") + note;
    s.bind(std::string(finished ? "finished" : "failed")).bind(reason);
    s.step();
  }
  const auto insert = [&](const char* table, int columns, const auto& list, const auto& put) {
    std::string places = "?";
    for (int i = 0; i < columns; ++i) places += ", ?";
    Statement s(database_, fmt::format("INSERT INTO {} VALUES ({})", table, places));
    long index = 0;
    for (const auto& x : list) {
      s.bind(key);
      put(s, x, ++index);
      s.again();
    }
  };
  insert("turns", 2, m.peaks, [](Statement& s, double x, long i) { s.bind(i).bind(x); });
  const auto contact = [&](int k) {
    const auto i = static_cast<std::size_t>(k);
    return i < r.contacts.size() ? r.contacts[i] : std::string();
  };
  insert("flights", 5, m.flights, [&](Statement& s, const Flight& f, long) {
    s.bind(f.loss).bind(f.angle).bind(f.duration).bind(f.deceleration).bind(contact(f.contact));
  });
  insert("impacts", 4, m.impacts, [&](Statement& s, const CountedImpact& i, long) {
    s.bind(i.angle).bind(i.approach).bind(i.impulse).bind(contact(i.contact));
  });
  for (std::size_t i = 0; i < r.measured.size(); ++i)
    insert("measures", 4, r.measured[i].parts,
           [&](Statement& s, const MeasureValue::Part& part, long number) {
             s.bind(measures_[i]).bind(number).bind(part.t).bind(part.value);
           });
  insert("spectra", 2, m.spectrum, [](Statement& s, double x, long i) { s.bind(i).bind(x); });
  if (one.start == 0)
    insert("traces", 3, m.last_turn, [](Statement& s, const TracePoint& p, long) {
      s.bind(p.angle).bind(p.acceleration).bind(p.position);
    });
  Statement(database_, "INSERT INTO costs VALUES (?, ?, ?, ?, ?)")
      .bind(key)
      .bind(r.cpu_seconds)
      .bind(r.work.steps)
      .bind(r.work.rhs)
      .bind(r.work.pivots)
      .step();
  WorkList::done(database_, key);
  whole.commit();
}

std::vector<RunRow> Results::runs(const std::set<std::string>& keys) const {
  std::vector<RunRow> rows;
  std::string order = "variant, formulation";
  for (std::size_t i = 0; i < axes_; ++i) order += fmt::format(", {}", 5 + i);
  Statement s(database_, "SELECT * FROM named WHERE status = 'finished' ORDER BY " + order + ", start");
  while (s.step()) {
    if (!keys.empty() && !keys.contains(s.text(0))) continue;
    RunRow r{s.text(0), s.text(1), s.text(2), static_cast<int>(s.number(3)), {}, {}, {}, {}};
    int column = 4;
    for (std::size_t i = 0; i < axes_; ++i) r.values.push_back(s.number(column++));
    for (auto& x : r.metric) x = s.number(column++);
    for (std::size_t i = 0; i < measures_.size(); ++i) r.measures.push_back(s.number(column++));
    r.doubt = s.text(column + 1);
    rows.push_back(std::move(r));
  }
  return rows;
}

std::vector<std::array<std::string, 3>> Results::failures() const {
  std::vector<std::array<std::string, 3>> list;
  Statement s(database_,
              "SELECT variant, formulation, reason FROM named WHERE status != 'finished' ORDER BY run");
  while (s.step()) list.push_back({s.text(0), s.text(1), s.text(2)});
  return list;
}

std::vector<KeptRuns> Results::kept() const {
  std::vector<KeptRuns> list;
  Statement s(
      database_,
      "SELECT variant, formulation, count(*) FROM runs WHERE run IN (SELECT run FROM work WHERE state = "
      "'kept') GROUP BY 1, 2 ORDER BY 1, 2");
  while (s.step()) list.push_back({s.text(0), s.text(1), static_cast<std::size_t>(s.whole(2))});
  return list;
}

void Results::prune() {
  Database::Transaction whole(database_);
  database_.execute("DELETE FROM runs WHERE run IN (SELECT run FROM work WHERE state = 'kept')");
  database_.execute("DELETE FROM work WHERE state = 'kept'");
  whole.commit();
}

std::vector<Flight> Results::flights(const std::string& key) const {
  std::vector<Flight> list;
  Statement s(database_,
              "SELECT loss, angle, duration, deceleration FROM flights WHERE run = ? ORDER BY rowid");
  s.bind(key);
  while (s.step()) list.push_back({s.number(0), s.number(1), s.number(2), s.number(3)});
  return list;
}

std::vector<CountedImpact> Results::impacts(const std::string& key) const {
  std::vector<CountedImpact> list;
  Statement s(database_, "SELECT angle, approach, impulse FROM impacts WHERE run = ? ORDER BY rowid");
  s.bind(key);
  while (s.step()) list.push_back({s.number(0), s.number(1), s.number(2)});
  return list;
}

std::vector<double> Results::spectrum(const std::string& key) const {
  std::vector<double> list;
  Statement s(database_, "SELECT amplitude FROM spectra WHERE run = ? ORDER BY harmonic");
  s.bind(key);
  while (s.step()) list.push_back(s.number(0));
  return list;
}

std::vector<TracePoint> Results::trace(const std::string& key) const {
  std::vector<TracePoint> list;
  Statement s(database_, "SELECT angle, acceleration, position FROM traces WHERE run = ? ORDER BY angle");
  s.bind(key);
  while (s.step()) list.push_back({s.number(0), s.number(1), s.number(2)});
  return list;
}

Deriver::Deriver(const Study& study) {
  auto names = names_of(study, true);
  for (const auto& d : study.derived) {
    expressions_.emplace_back(d.expression, names);
    names.push_back(d.name);
  }
}

std::vector<double> Deriver::operator()(const RunRow& row) const {
  auto values = row.values;
  values.insert(values.end(), row.metric.begin(), row.metric.end());
  values.insert(values.end(), row.measures.begin(), row.measures.end());
  const auto given = values.size();
  for (const auto& expression : expressions_) values.push_back(expression(values));
  values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(given));
  return values;
}

void Results::derive(const Study& study) {
  const Deriver derived(study);
  std::string columns, shown, marks = "?";
  for (const auto& d : study.derived) {
    columns += fmt::format(", \"{}\" REAL", d.name);
    shown += fmt::format(", derived.\"{}\"", d.name);
    marks += ", ?";
  }
  Database::Transaction whole(database_);
  database_.execute("DROP VIEW IF EXISTS named");
  database_.execute("DROP TABLE IF EXISTS derived");
  database_.execute(fmt::format(
      "CREATE TABLE derived (run TEXT PRIMARY KEY REFERENCES runs(run) ON DELETE CASCADE{})", columns));
  make_view(database_, shown);
  const auto rows = runs();
  {
    Statement s(database_, fmt::format("INSERT INTO derived VALUES ({})", marks));
    for (const auto& row : rows) {
      s.bind(row.key);
      for (const double x : derived(row)) s.bind(x);
      s.again();
    }
  }
  whole.commit();
}

double Results::cpu_seconds() const {
  Statement s(database_, "SELECT sum(cpu_s) FROM costs WHERE run IN (SELECT run FROM named)");
  return s.step() ? s.number(0) : 0;
}

}  // namespace freeplay
