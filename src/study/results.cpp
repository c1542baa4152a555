#include "study/results.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cmath>

#include "io/output_file.hpp"

namespace freeplay {
namespace {

/// What the keys in a file are made from, in its user_version. 0: the commit and a list of fields, as before runs
/// had an identity; 1: the digest of the identity.
constexpr int kind_of_keys = 1;

/// Why the database does not do what it is asked, and what would help.
std::string reason(int code) {
  switch (code & 0xff) {
    case SQLITE_NOTADB:
      return "it is no database of results; move it away, or give another folder with -o";
    case SQLITE_CORRUPT:
    case SQLITE_ERROR:
    case SQLITE_MISMATCH:
    case SQLITE_SCHEMA:
      return "it is damaged, or another program's; restore it, or give another folder with -o";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "another program has held it for a minute; try again when that has ended";
    case SQLITE_FULL:
      return "the disk is full";
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return "it may not be written here";
    case SQLITE_CANTOPEN:
      return "the file or its folder cannot be opened";
    case SQLITE_NOMEM:
      return "out of memory";
    default:
      return fmt::format("the disk refused (code {})", code);
  }
}

}  // namespace

/// A prepared statement: bind in order, step through rows.
class Results::Statement {
 public:
  Statement(const Results& owner, const std::string& sql) : owner_(owner) {
    if (sqlite3_prepare_v2(owner.db_, sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK)
      owner.fail("cannot be read");
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(double x) {
    // NaN becomes NULL: a statistic that a run does not have.
    sqlite3_bind_double(statement_, ++bound_, x);
    return *this;
  }
  Statement& bind(long x) {
    sqlite3_bind_int64(statement_, ++bound_, x);
    return *this;
  }
  Statement& bind(const std::string& x) {
    sqlite3_bind_text(statement_, ++bound_, x.c_str(), -1, SQLITE_TRANSIENT);
    return *this;
  }
  bool step() {
    const int status = sqlite3_step(statement_);
    if (status != SQLITE_ROW && status != SQLITE_DONE) owner_.fail("cannot be read or written");
    return status == SQLITE_ROW;
  }
  void again() {
    step();
    sqlite3_reset(statement_);
    bound_ = 0;
  }
  std::string text(int column) const {
    const auto* t = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return t ? t : "";
  }
  double number(int column) const {
    if (sqlite3_column_type(statement_, column) == SQLITE_NULL) return std::nan("");
    return sqlite3_column_double(statement_, column);
  }

 private:
  const Results& owner_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

void Results::fail(const std::string& what) const {
  throw OutputError(fmt::format("{}: {}: {}", file_.string(), what, reason(sqlite3_errcode(db_))));
}

void Results::execute(const std::string& sql) const {
  if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail("cannot be written");
}

Results::Results(const std::filesystem::path& file, const Study& study)
    : file_(file), axes_(study.axes.size()) {
  for (const char* part : {"", "-wal", "-shm", "-journal"}) require_own(file.string() + part);
  if (sqlite3_open(file.c_str(), &db_) != SQLITE_OK) fail("cannot be opened");
  sqlite3_busy_timeout(db_, 60000);
  // A user's query, however long, does not hold up the runs; a stop at any moment loses unstored runs only.
  execute("PRAGMA journal_mode = WAL");
  std::string columns;
  for (const auto& axis : study.axes) columns += fmt::format("\"{}\" REAL, ", axis.name);
  for (const auto& name : TurnMetrics::names()) columns += fmt::format("{} REAL, ", name);
  const auto table = fmt::format(
      "CREATE TABLE runs (run TEXT PRIMARY KEY, variant TEXT, formulation TEXT, start INTEGER, {}"
      "status TEXT, reason TEXT)",
      columns);
  execute("PRAGMA foreign_keys = ON");
  {
    Statement existing(*this, "SELECT sql FROM sqlite_master WHERE name = 'runs'");
    if (existing.step()) {
      Statement kind(*this, "PRAGMA user_version");
      if (kind.step() && kind.number(0) != kind_of_keys)
        throw OutputError(
            fmt::format("{}: its runs were stored by {} freeplay, by keys that do not say what this one's "
                        "do; they stay as they "
                        "are, and none is used: give another folder with -o, or move the file away",
                        file_.string(), kind.number(0) < kind_of_keys ? "an earlier" : "a later"));
      if (existing.text(0) != table)
        throw OutputError(fmt::format(
            "{}: holds another study, or one of another version; give another folder with -o, or remove it",
            file_.string()));
      return;
    }
  }
  const char* of_run = "run TEXT REFERENCES runs(run) ON DELETE CASCADE";
  execute("BEGIN");
  execute(fmt::format("PRAGMA user_version = {}", kind_of_keys));
  execute(table);
  execute(fmt::format("CREATE TABLE turns ({}, turn INTEGER, peak REAL)", of_run));
  execute(fmt::format("CREATE TABLE flights ({}, loss REAL, angle REAL, duration REAL, deceleration REAL)",
                      of_run));
  execute(fmt::format("CREATE TABLE impacts ({}, angle REAL, approach REAL, impulse REAL)", of_run));
  execute(fmt::format("CREATE TABLE spectra ({}, harmonic INTEGER, amplitude REAL)", of_run));
  execute(fmt::format("CREATE TABLE traces ({}, angle REAL, acceleration REAL, position REAL)", of_run));
  execute(fmt::format(
      "CREATE TABLE costs ({}, cpu_s REAL, steps INTEGER, right_hand_sides INTEGER, pivots INTEGER)",
      of_run));
  for (const char* name : {"turns", "flights", "impacts", "spectra", "traces", "costs"})
    execute(fmt::format("CREATE INDEX {0}_run ON {0}(run)", name));
  execute("COMMIT");
}

Results::~Results() { sqlite3_close(db_); }

std::set<std::string> Results::keys() const {
  std::set<std::string> keys;
  Statement s(*this, "SELECT run FROM runs");
  while (s.step()) keys.insert(s.text(0));
  return keys;
}

void Results::retain(const std::set<std::string>& keep) {
  execute("BEGIN");
  for (const auto& key : keys())
    if (!keep.contains(key)) Statement(*this, "DELETE FROM runs WHERE run = ?").bind(key).step();
  execute("COMMIT");
}

void Results::store(const std::string& key, const Case& one, const CaseResult& r) {
  execute("BEGIN");
  const auto& m = r.metrics;
  std::string marks = "?, ?, ?, ?";
  for (std::size_t i = 0; i < axes_ + TurnMetrics::count + 2; ++i) marks += ", ?";
  const bool finished = r.ending.status == Ending::Status::finished;
  {
    Statement s(*this, "INSERT OR REPLACE INTO runs VALUES (" + marks + ")");
    s.bind(key).bind(one.variant).bind(one.formulation).bind(static_cast<long>(one.start));
    for (double x : one.values) s.bind(x);
    for (double x : m.value) s.bind(finished ? x : std::nan(""));
    auto reason = r.ending.reason;
    for (const auto& note : r.notes)
      if (finished && note.starts_with("DOUBTFUL")) reason += (reason.empty() ? "" : "; ") + note;
    s.bind(std::string(finished ? "finished" : "failed")).bind(reason);
    s.step();
  }
  const auto insert = [&](const char* table, int columns, const auto& list, const auto& put) {
    std::string places = "?";
    for (int i = 0; i < columns; ++i) places += ", ?";
    Statement s(*this, fmt::format("INSERT INTO {} VALUES ({})", table, places));
    long index = 0;
    for (const auto& x : list) {
      s.bind(key);
      put(s, x, ++index);
      s.again();
    }
  };
  insert("turns", 2, m.peaks, [](Statement& s, double x, long i) { s.bind(i).bind(x); });
  insert("flights", 4, m.flights, [](Statement& s, const Flight& f, long) {
    s.bind(f.loss).bind(f.angle).bind(f.duration).bind(f.deceleration);
  });
  insert("impacts", 3, m.impacts, [](Statement& s, const CountedImpact& i, long) {
    s.bind(i.angle).bind(i.approach).bind(i.impulse);
  });
  insert("spectra", 2, m.spectrum, [](Statement& s, double x, long i) { s.bind(i).bind(x); });
  if (one.start == 0)
    insert("traces", 3, m.last_turn, [](Statement& s, const TracePoint& p, long) {
      s.bind(p.angle).bind(p.acceleration).bind(p.position);
    });
  Statement(*this, "INSERT INTO costs VALUES (?, ?, ?, ?, ?)")
      .bind(key)
      .bind(r.cpu_seconds)
      .bind(r.work.steps)
      .bind(r.work.rhs)
      .bind(r.work.pivots)
      .step();
  execute("COMMIT");
}

std::vector<RunRow> Results::runs(const std::set<std::string>& keys) const {
  std::vector<RunRow> rows;
  std::string order = "variant, formulation";
  for (std::size_t i = 0; i < axes_; ++i) order += fmt::format(", {}", 5 + i);
  Statement s(*this, "SELECT * FROM runs WHERE status = 'finished' ORDER BY " + order + ", start");
  while (s.step()) {
    if (!keys.empty() && !keys.contains(s.text(0))) continue;
    RunRow r{s.text(0), s.text(1), s.text(2), static_cast<int>(s.number(3)), {}, {}, {}};
    int column = 4;
    for (std::size_t i = 0; i < axes_; ++i) r.values.push_back(s.number(column++));
    for (auto& x : r.metric) x = s.number(column++);
    r.doubt = s.text(column + 1);
    rows.push_back(std::move(r));
  }
  return rows;
}

std::vector<std::array<std::string, 3>> Results::failures() const {
  std::vector<std::array<std::string, 3>> list;
  Statement s(*this, "SELECT variant, formulation, reason FROM runs WHERE status != 'finished' ORDER BY run");
  while (s.step()) list.push_back({s.text(0), s.text(1), s.text(2)});
  return list;
}

std::vector<Flight> Results::flights(const std::string& key) const {
  std::vector<Flight> list;
  Statement s(*this, "SELECT loss, angle, duration, deceleration FROM flights WHERE run = ? ORDER BY rowid");
  s.bind(key);
  while (s.step()) list.push_back({s.number(0), s.number(1), s.number(2), s.number(3)});
  return list;
}

std::vector<CountedImpact> Results::impacts(const std::string& key) const {
  std::vector<CountedImpact> list;
  Statement s(*this, "SELECT angle, approach, impulse FROM impacts WHERE run = ? ORDER BY rowid");
  s.bind(key);
  while (s.step()) list.push_back({s.number(0), s.number(1), s.number(2)});
  return list;
}

std::vector<double> Results::spectrum(const std::string& key) const {
  std::vector<double> list;
  Statement s(*this, "SELECT amplitude FROM spectra WHERE run = ? ORDER BY harmonic");
  s.bind(key);
  while (s.step()) list.push_back(s.number(0));
  return list;
}

std::vector<TracePoint> Results::trace(const std::string& key) const {
  std::vector<TracePoint> list;
  Statement s(*this, "SELECT angle, acceleration, position FROM traces WHERE run = ? ORDER BY angle");
  s.bind(key);
  while (s.step()) list.push_back({s.number(0), s.number(1), s.number(2)});
  return list;
}

double Results::cpu_seconds() const {
  Statement s(*this, "SELECT sum(cpu_s) FROM costs");
  return s.step() ? s.number(0) : 0;
}

}  // namespace freeplay
