#include "study/store/results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "numerics/quantiles.hpp"
#include "study/store/schema.hpp"
#include "values/warning.hpp"

namespace freeplay {
namespace {

StoreForm form_of(const Study& study) {
  std::string columns = "run TEXT UNIQUE, variant TEXT, formulation TEXT, start INTEGER, ";
  for (const auto& axis : study.axes) columns += fmt::format("\"{}\" REAL, ", axis.name);
  for (const auto& name : TurnMetrics::names()) columns += fmt::format("{} REAL, ", name);
  for (const auto& measure : study.measures) columns += fmt::format("\"{}\" REAL, ", measure.name);
  columns += "status TEXT, reason TEXT, \"run id\" INTEGER PRIMARY KEY";
  return {.kind = 3, .columns = columns, .lists = lists_of_runs, .divided = true};
}

}  // namespace

PackedTrace packed(const std::vector<TracePoint>& trace) {
  PackedTrace out;
  const auto n = trace.size();
  if (n == 0) return out;
  const double first = trace.front().angle,
               step = n > 1 ? (trace.back().angle - first) / static_cast<double>(n - 1) : 0;
  bool even = n > 2, placed = false;
  for (std::size_t i = 0; i < n; ++i) {
    even = even && std::abs(trace[i].angle - first - static_cast<double>(i) * step) <= 1e-6 * step;
    placed = placed || !std::isnan(trace[i].position);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!even || i == 0 || i == n - 1) out.angle.push_back(static_cast<float>(trace[i].angle));
    out.acceleration.push_back(static_cast<float>(trace[i].acceleration));
    if (placed) out.position.push_back(static_cast<float>(trace[i].position));
  }
  return out;
}

std::vector<TracePoint> unpacked(const PackedTrace& trace) {
  const auto n = trace.acceleration.size();
  const bool even = trace.angle.size() != n;
  // The file may be of unknown origin: inconsistent blobs count as no trace.
  if ((even && (trace.angle.size() != 2 || n < 2)) || (!trace.position.empty() && trace.position.size() != n))
    return {};
  std::vector<TracePoint> out(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(std::max<std::size_t>(n - 1, 1));
    out[i].angle = even ? trace.angle[0] + share * (double(trace.angle[1]) - trace.angle[0]) : trace.angle[i];
    out[i].acceleration = trace.acceleration[i];
    out[i].position = trace.position.empty() ? std::nan("") : trace.position[i];
  }
  return out;
}

namespace {

using Statement = Database::Statement;

double finite(double x) { return std::isfinite(x) ? x : std::nan(""); }

/// Stores one run. `measures`: their names.
void put(Database::Transaction& into, const MadeRun& made, const std::vector<std::string>& measures) {
  const auto& [key, what, r] = made;
  const auto& m = r.metrics;
  const bool finished = r.ending.status == Ending::Status::finished;
  auto numbers = what->values;
  for (const double x : m.value) numbers.push_back(finished ? finite(x) : std::nan(""));
  for (std::size_t i = 0; i < measures.size(); ++i)
    numbers.push_back(finished ? finite(r.measured[i].value) : std::nan(""));
  auto reason = r.ending.reason;
  for (const auto& note : r.notes)
    if (finished && is_warning(note)) reason += (reason.empty() ? "" : "; ") + note;
  const long id = into.insert("runs", key, what->variant, what->formulation, static_cast<long>(what->start),
                              Database::Columns{numbers}, std::string(finished ? "finished" : "failed"),
                              reason, std::nan(""));  // SQLite gives the last column

  const auto contact = [&](int k) {
    const auto i = static_cast<std::size_t>(k);
    return i < r.contacts.size() ? r.contacts[i] : std::string();
  };
  for (std::size_t i = 0; i < m.peaks.size(); ++i)
    into.insert("turn_rows", id, static_cast<long>(i + 1), m.peaks[i]);
  for (const auto& f : m.flights)
    into.insert("flight_rows", id, f.loss, f.angle, f.duration, f.deceleration, contact(f.contact));
  for (const auto& i : m.impacts)
    into.insert("impact_rows", id, i.angle, i.approach, i.impulse, contact(i.contact));
  for (std::size_t i = 0; i < r.measured.size(); ++i) {
    long number = 0;
    for (const auto& part : r.measured[i].parts)
      into.insert("measure_rows", id, measures[i], ++number, part.t, part.value);
  }
  const std::vector<float> amplitudes(m.spectrum.begin(), m.spectrum.end());
  if (!amplitudes.empty()) into.insert("spectrum_blobs", id, amplitudes);
  if (what->start == 0 && !m.last_turn.empty()) {
    const auto trace = packed(m.last_turn);
    into.insert("trace_blobs", id, trace.angle, trace.acceleration, trace.position);
  }
  into.insert("cost_rows", id, r.cpu_seconds, r.work.steps, r.work.rhs, r.work.pivots);
}

}  // namespace

Results::Results(const std::filesystem::path& file, const Study& study, StopToken stop)
    : RunStore(file, Database::Access::write, form_of(study), stop), axes_(study.axes.size()) {
  for (const auto& m : study.measures) measures_.push_back(m.name);
  const auto make = [this](const std::string& view) {
    database_.execute("CREATE VIEW IF NOT EXISTS " + view);
  };
  for (const auto& list : lists_of_runs) make(view_of(database_, list));
  make(view_of_named(database_));
}

void Results::store(std::span<const MadeRun> batch) {
  if (batch.empty()) return;
  Database::Transaction whole(database_);
  Statement done(database_, WorkList::done);
  for (const auto& made : batch) {
    put(whole, made, measures_);
    done.put(made.key);
  }
  whole.commit();
}

std::set<std::string> Results::keys() const {
  const auto keys = database_.texts("SELECT run FROM runs");
  return {keys.begin(), keys.end()};
}

std::vector<RunRow> Results::runs(const std::set<std::string>& keys) const {
  std::vector<RunRow> rows;
  std::string order = "variant, formulation";
  for (std::size_t i = 0; i < axes_; ++i) order += fmt::format(", {}", 5 + i);
  Statement s(database_, "SELECT * FROM named WHERE status = 'finished' ORDER BY " + order + ", start");
  while (s.step()) {
    if (!keys.empty() && !keys.contains(s.text(0))) continue;
    RunRow r{s.text(0), s.text(1), s.text(2), static_cast<int>(s.whole(3)), {}, {}, {}, {}};
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
  using Text = std::string;
  return database_.list<std::array<Text, 3>, Text, Text, Text>(
      "SELECT variant, formulation, reason FROM named WHERE status != 'finished' ORDER BY run");
}

std::vector<KeptRuns> Results::kept() const {
  return database_.list<KeptRuns, std::string, std::string, std::size_t>(
      "SELECT variant, formulation, count(*) FROM runs WHERE run IN (SELECT run FROM work WHERE state = "
      "'kept') GROUP BY 1, 2 ORDER BY 1, 2");
}

void Results::prune() {
  Database::Transaction whole(database_);
  database_.execute("DELETE FROM runs WHERE run IN (SELECT run FROM work WHERE state = 'kept')");
  database_.execute("DELETE FROM work WHERE state = 'kept'");
  whole.commit();
}

std::vector<Flight> Results::flights(const std::string& key) const {
  return database_.list<Flight, double, double, double, double>(
      "SELECT loss, angle, duration, deceleration FROM flights WHERE run = ?", key);
}

std::vector<CountedImpact> Results::impacts(const std::string& key) const {
  return database_.list<CountedImpact, double, double, double>(
      "SELECT angle, approach, impulse FROM impacts WHERE run = ?", key);
}

std::vector<double> Results::spectrum(const std::string& key) const {
  Statement s(database_, "SELECT amplitude FROM spectra WHERE run = ?", key);
  if (!s.step()) return {};
  const auto blob = s.floats(0);
  return {blob.begin(), blob.end()};
}

std::vector<TracePoint> Results::trace(const std::string& key) const {
  Statement s(database_, "SELECT angle, acceleration, position FROM traces WHERE run = ?", key);
  if (!s.step()) return {};
  return unpacked({s.floats(0), s.floats(1), s.floats(2)});
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
  std::string columns;
  for (const auto& d : study.derived) columns += fmt::format(", \"{}\" REAL", d.name);
  Database::Transaction whole(database_);
  database_.execute("DROP VIEW IF EXISTS named");
  database_.execute("DROP TABLE IF EXISTS derived");
  database_.execute(fmt::format(
      "CREATE TABLE derived (run TEXT PRIMARY KEY REFERENCES runs(run) ON DELETE CASCADE{}) WITHOUT ROWID",
      columns));
  database_.execute("CREATE VIEW " + view_of_named(database_));
  for (const auto& row : runs()) whole.insert("derived", row.key, Database::Columns{derived(row)});
  whole.commit();
}

double Results::cpu_seconds() const {
  Statement s(database_, "SELECT sum(cpu_s) FROM costs WHERE run IN (SELECT run FROM named)");
  return s.step() ? s.number(0) : 0;
}

Interval interval(const std::vector<double>& values) {
  Interval s;
  const double nan = std::nan("");
  s.least = INFINITY;
  s.greatest = -INFINITY;
  for (double x : values) {
    if (!std::isfinite(x)) continue;
    ++s.count;
    s.mean += x;
    s.least = std::min(s.least, x);
    s.greatest = std::max(s.greatest, x);
  }
  if (s.count == 0) return {0, nan, nan, nan, nan, nan};
  s.mean /= s.count;
  s.low = s.high = nan;
  if (s.count < 2) return s;
  double squares = 0;
  for (double x : values)
    if (std::isfinite(x)) squares += (x - s.mean) * (x - s.mean);
  const double t = student_quantile(s.count - 1, 0.975);
  const double half = t * std::sqrt(squares / (s.count - 1) / s.count);
  s.low = s.mean - half;
  s.high = s.mean + half;
  return s;
}

Interval interval_of_directions(const std::vector<double>& degrees) {
  std::vector<double> known;
  for (double x : degrees)
    if (std::isfinite(x)) known.push_back(x);
  const double mean = mean_angle(known);
  for (double& x : known) x = half_circle(x - mean);
  auto s = interval(known);
  if (s.count == 0) return s;
  const double half = 0.5 * (s.high - s.low);
  s.mean = mean;
  s.low = half < 90 ? mean - half : std::nan("");
  s.high = half < 90 ? mean + half : std::nan("");
  s.least += mean;
  s.greatest += mean;
  return s;
}

Interval within_range(Interval s, TurnMetrics::Kind kind) {
  const double half = 0.5 * (s.high - s.low), x = s.mean;
  if (std::isnan(half)) return s;
  if (kind == TurnMetrics::Kind::positive) {
    s.low = x > 0 ? x * std::exp(-half / x) : 0;
    s.high = x > 0 ? x * std::exp(half / x) : 0;
  } else if (kind == TurnMetrics::Kind::share) {
    const auto at = [x](double e) { return 1 / (1 + (1 - x) / x * std::exp(e)); };
    const bool inside = x > 0 && x < 1;
    s.low = inside ? at(half / (x * (1 - x))) : x;
    s.high = inside ? at(-half / (x * (1 - x))) : x;
  }
  return s;
}

static Interval of_starts(const std::vector<double>& values, TurnMetrics::Name metric) {
  const auto kind = TurnMetrics::kind(metric);
  if (kind == TurnMetrics::Kind::direction) return interval_of_directions(values);
  const auto s = interval(values);
  return s.low < 0 || (kind == TurnMetrics::Kind::share && s.high > 1) ? within_range(s, kind) : s;
}

Interval cell(const std::vector<RunRow>& runs, const std::string& variant, const std::string& formulation,
              const std::vector<double>& values, TurnMetrics::Name metric) {
  return Cells(runs).of(variant, formulation, values, metric);
}

Cells::Cells(const std::vector<RunRow>& runs) {
  for (const auto& r : runs) runs_[{r.variant, r.formulation, r.values}].push_back(&r);
}

const std::vector<const RunRow*>& Cells::at(const std::string& variant, const std::string& formulation,
                                            const std::vector<double>& values) const {
  static const std::vector<const RunRow*> none;
  const auto found = runs_.find({variant, formulation, values});
  return found == runs_.end() ? none : found->second;
}

Interval Cells::of(const std::string& variant, const std::string& formulation,
                   const std::vector<double>& values, TurnMetrics::Name metric) const {
  std::vector<double> list;
  for (const auto* r : at(variant, formulation, values)) list.push_back(r->metric[metric]);
  return of_starts(list, metric);
}

}  // namespace freeplay
