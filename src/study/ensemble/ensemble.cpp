#include "study/ensemble/ensemble.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>

#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "io/files/escaping.hpp"
#include "io/scene/toml_text.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "simulation/clock.hpp"
#include "simulation/statistics.hpp"
#include "study/runs/executor.hpp"
#include "study/runs/measurer.hpp"

namespace freeplay {

/// Observer that records chosen columns at given times.
class Sampled final : public Observer {
 public:
  Sampled(const std::vector<Column>& columns, const std::vector<double>& times, double* rows)
      : columns_(columns), times_(times), rows_(rows) {}

  void begin(const Layout& layout, const State& state) override {
    data_.begin(layout, state);
    for (const auto& c : columns_) places_ |= c.of == Column::Of::contact;
  }
  /// Time (s) before which no step is recorded.
  double next() const { return next_ < times_.size() ? times_[next_] - slack() : INFINITY; }
  void step(const Step& step) override {
    const double slack = this->slack();
    for (; next_ < times_.size() && times_[next_] <= step.t1 + slack; ++next_) {
      const double t = std::clamp(times_[next_], step.t0, step.t1);
      step.state(t, data_.q, data_.v);
      if (places_) step.contacts(t, data_.q, data_.contacts);
      for (const auto& c : columns_) *rows_++ = data_.value(c, t);
    }
  }

 private:
  /// The last time may exceed the end of the last step by rounding.
  double slack() const { return 1e-12 * times_.back(); }

  const std::vector<Column>& columns_;
  const std::vector<double>& times_;
  double* rows_;
  std::size_t next_ = 0;
  bool places_ = false;
  ColumnData data_;
};

namespace {

constexpr double most_bytes = 2e9;

std::vector<Column> chosen(const Layout& layout, const std::vector<std::string>& names) {
  std::vector<Column> all = trajectory_columns(layout), found;
  std::vector<std::string> there;
  std::erase_if(all, [](const Column& c) { return c.of == Column::Of::time; });
  for (const auto& c : all) there.push_back(c.name());
  for (const auto& name : names) {
    const auto at = std::ranges::find(there, name);
    if (at == there.end())
      throw SceneError(fmt::format("--column {}: is not a column of trajectory.csv; columns are {}",
                                   visible(name), fmt::join(there, ", ")));
    found.push_back(all[static_cast<std::size_t>(at - there.begin())]);
  }
  if (!names.empty()) return found;
  for (const auto& c : all)
    if (layout.contacts.empty() ? c.of == Column::Of::position
                                : c.of == Column::Of::contact && std::string_view(c.part) == "gap")
      found.push_back(c);
  return found;
}

/// Whether a number describes the computation, not the mechanism.
bool of_the_machine(const std::string& name) {
  return name.starts_with("work.") || name.find("seconds") != name.npos || name.find("memory") != name.npos;
}

void put_statistics(Ensemble& all, const std::vector<StartOutcome>& outcomes) {
  std::set<std::string> names;
  for (const auto& o : outcomes)
    for (const auto& number : o.numbers) names.insert(number.first);
  all.statistics.assign(names.begin(), names.end());
  for (const auto& o : outcomes) {
    auto& row = all.runs.emplace_back();
    for (const auto& name : all.statistics) {
      const auto at = o.numbers.find(name);
      row.push_back(at == o.numbers.end() ? std::nan("") : at->second);
    }
  }
  for (std::size_t s = 0; s < all.statistics.size(); ++s) {
    std::vector<double> values;
    for (const auto& row : all.runs) values.push_back(row[s]);
    all.spreads.push_back(spread(std::move(values)));
  }
}

}  // namespace

Spread spread(std::vector<double> values) {
  std::erase_if(values, [](double x) { return !std::isfinite(x); });
  Spread s;
  s.of = interval(values);
  s.quantile.fill(std::nan(""));
  s.error = std::nan("");
  if (values.empty()) return s;
  std::ranges::sort(values);
  for (std::size_t i = 0; i < band_levels.size(); ++i) s.quantile[i] = quantile(values, band_levels[i]);
  if (values.size() < 2) return s;
  double squares = 0;
  for (const double x : values) squares += (x - s.of.mean) * (x - s.of.mean);
  const auto n = static_cast<double>(values.size());
  s.error = std::sqrt(squares / (n - 1) / n);
  return s;
}

std::size_t Ensemble::finished() const {
  return static_cast<std::size_t>(std::ranges::count_if(failures, [](const auto& f) { return f.empty(); }));
}

Starts::Starts(const Scene& scene, const EnsemblePlan& plan) : scene_(scene), plan_(plan) {
  require_differing_starts(scene, plan.how, "; vary initial values by --vary KEY=RANGE");
  if (scene.run.start == RunOptions::Start::equilibrium)
    throw SceneError(
        fmt::format("{}: starts in equilibrium, which cannot be perturbed; use run.start = \"ideal\"",
                    scene.file.string()));
  const auto layout = Simulation(scene, plan.formulation, {.matched = true, .stop = plan.stop}).layout();
  columns_ = chosen(layout, plan.columns);
  const double from = scene.run.discard, to = scene.run.duration;
  for (int i = 0; i < plan.rows; ++i) times_.push_back(from + (to - from) * i / (plan.rows - 1));
  const double bytes =
      8.0 * plan.starts * static_cast<double>(plan.rows) * static_cast<double>(columns_.size());
  if (bytes > most_bytes)
    throw SceneError(fmt::format(
        "--rows {}: bands of {} starts and {} columns need {:.3g} GB of memory, above the limit of {:.0f}; "
        "use fewer rows or columns",
        plan.rows, plan.starts, columns_.size(), 1e-9 * bytes, 1e-9 * most_bytes));
  near_ = ideal_pose(scene, plan.stop);
  require_variable(scene, near_, plan.stop, plan.how.vary);
}

/// One start: its simulation and observers.
struct Starts::Run final : StudyRun {
  Run(const Starts& all, int start, std::size_t its_place, SharedCompilation& compilation)
      : place(its_place),
        stop(all.plan_.stop),
        scene(perturbed(all.scene_, all.near_, stop, all.plan_.seed, start, all.plan_.how)),
        made(scene, all.plan_.formulation, options(all.plan_, compilation)),
        rows(all.times_.size() * all.columns_.size(), std::nan("")),
        sampled(all.columns_, all.times_, rows.data()),
        contacts(scene.run.discard),
        window(scene.run.discard, scene.run.duration) {
    outcome.cpu_seconds = thread_seconds() - began;
  }
  SimulationOptions options(const EnsemblePlan& plan, SharedCompilation& compilation) const {
    auto options = compilation.options(scene, plan.formulation);
    options.matched = true;
    options.stop = plan.stop;
    options.checked = true;
    return options;
  }
  Simulation& simulation() override { return made; }
  RunRequest request() override {
    return {.observers = {&contacts, &window, &sampled}, .keep_events = false, .stop = stop};
  }
  double next_shown() const override { return std::min(window.next(), sampled.next()); }
  bool take(Result run) override {
    outcome.rows = std::move(rows);
    outcome.interrupted = run.ending.status == Ending::Status::interrupted;
    outcome.steps = run.work.steps;
    outcome.cpu_seconds += run.cpu_seconds;
    if (run.ending.status != Ending::Status::finished) {
      outcome.failure = run.ending.reason.empty() ? "did not finish" : run.ending.reason;
      return false;
    }
    contacts.into(run);
    window.into(run);
    outcome.numbers = numbers_of(run);
    std::erase_if(outcome.numbers,
                  [](const auto& n) { return !std::isfinite(n.second) || of_the_machine(n.first); });
    return false;
  }

  const double began = thread_seconds();
  std::size_t place;  // in the list
  StopToken stop;
  Scene scene;
  Simulation made;
  std::vector<double> rows;
  Sampled sampled;
  ContactStatistics contacts;
  WindowStatistics window;
  StartOutcome outcome;
};

namespace {

/// Calls f(); an error becomes the outcome's.
template <class F>
void noting_errors(StartOutcome& outcome, F f) {
  try {
    f();
  } catch (const Interrupted&) {
    outcome.interrupted = true;
    outcome.failure = "interrupted";
  } catch (const ModelError& e) {
    outcome.failure = e.what();
  }
}

}  // namespace

Ensemble Starts::together(const std::vector<StartOutcome>& outcomes) const {
  Ensemble all;
  for (const auto& c : columns_) all.columns.push_back(c.name());
  all.t = times_;
  all.interrupted = plan_.stop();
  for (const auto& o : outcomes) {
    all.failures.push_back(o.failure);
    all.cpu_seconds += o.cpu_seconds;
    all.steps += o.steps;
    all.in_lanes += o.in_lanes;
  }
  if (all.interrupted) return all;
  put_statistics(all, outcomes);
  std::vector<double> values;
  for (std::size_t place = 0; place < times_.size() * columns_.size(); ++place) {
    values.clear();
    for (const auto& o : outcomes)
      if (o.failure.empty()) values.push_back(o.rows[place]);
    all.bands.push_back(spread(values));
  }
  return all;
}

void Starts::make_all(const std::vector<int>& starts, const EnsembleStore* known,
                      const std::function<void(std::size_t, StartOutcome&, bool)>& done) const {
  std::mutex guard;
  std::size_t next_place = 0;
  SharedCompilation compilation;
  compilation.runs = starts.size();
  const auto all_starts = known ? identity(scene_, plan_) : Identity();
  const auto next = [&]() -> std::unique_ptr<StudyRun> {
    while (!plan_.stop()) {
      StartOutcome outcome;
      std::size_t place = 0;
      {
        const std::lock_guard lock(guard);
        place = next_place++;
        if (place >= starts.size()) break;
        if (known) outcome.key = run_key(all_starts, starts[place]);
        if (known && known->find(outcome)) {
          if (outcome.failure.empty() && outcome.rows.size() != times_.size() * columns_.size())
            throw SceneError(
                fmt::format("ensemble.db: start {} has {} values instead of {}: it is damaged; remove it",
                            starts[place], outcome.rows.size(), times_.size() * columns_.size()));
          done(place, outcome, true);
          continue;
        }
      }
      std::unique_ptr<Run> run;
      noting_errors(outcome, [&] { run = std::make_unique<Run>(*this, starts[place], place, compilation); });
      if (run) {
        run->outcome.key = std::move(outcome.key);
        return run;
      }
      const std::lock_guard lock(guard);
      done(place, outcome, false);
    }
    return nullptr;
  };
  execute(plan_.threads, starts.size(), plan_.stop, next, [&](StudyRun& made) {
    auto& run = static_cast<Run&>(made);
    run.outcome.in_lanes = run.in_lanes;
    const std::lock_guard lock(guard);
    done(run.place, run.outcome, false);
  });
}

Ensemble run_ensemble(const Scene& scene, const EnsemblePlan& plan,
                      const std::function<void(double)>& on_progress, const EnsembleStore* known) {
  const auto began = std::chrono::steady_clock::now();
  const Starts starts(scene, plan);
  std::vector<int> list(static_cast<std::size_t>(plan.starts));
  std::iota(list.begin(), list.end(), 0);
  std::vector<StartOutcome> outcomes(list.size());
  int done = 0;
  starts.make_all(list, known, [&](std::size_t place, StartOutcome& outcome, bool) {
    outcomes[place] = std::move(outcome);
    if (on_progress) on_progress(static_cast<double>(++done) / plan.starts);
  });
  auto all = starts.together(outcomes);
  all.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return all;
}

// Contents of the result files.

namespace {

/// A number that is not finite is an empty field.
Table::Cell number(double x) { return std::isfinite(x) ? Table::Cell(x) : Table::Cell(std::string()); }

Table with_spread(const char* columns) {
  Table table(columns);
  for (const char* name : {"count", "mean", "error", "low", "high", "least", "greatest"}) table.column(name);
  for (const double level : band_levels) table.column(fmt::format("q{:02.0f}", 100 * level));
  return table;
}
void add(Table& table, std::vector<Table::Cell> row, const Spread& s) {
  row.push_back(Table::cell(s.of.count));
  for (const double x : {s.of.mean, s.error, s.of.low, s.of.high, s.of.least, s.of.greatest})
    row.push_back(number(x));
  for (const double x : s.quantile) row.push_back(number(x));
  table.row(std::move(row));
}

}  // namespace

nlohmann::json to_json(const EnsemblePlan& plan, const Ensemble& all) {
  nlohmann::json document = {{"ensemble",
                              {{"formulation", plan.formulation},
                               {"starts", plan.starts},
                               {"finished", all.finished()},
                               {"seed", plan.seed},
                               {"turn", plan.how.turn},
                               {"play", plan.how.play},
                               {"steps", all.steps},
                               {"steps_in_lanes", all.in_lanes},
                               {"wall_seconds", all.wall_seconds},
                               {"cpu_seconds", all.cpu_seconds}}}};
  for (const auto& value : plan.how.vary) document["ensemble"]["vary"][value.key] = value.half;
  return document;
}

Table statistics_table(const Ensemble& all) {
  auto table = with_spread("statistic");
  for (std::size_t i = 0; i < all.statistics.size(); ++i) add(table, {all.statistics[i]}, all.spreads[i]);
  return table;
}

Table runs_table(const Ensemble& all) {
  Table table("start,finished");
  for (const auto& name : all.statistics) table.column(name);
  for (std::size_t k = 0; k < all.runs.size(); ++k) {
    std::vector<Table::Cell> row{Table::cell(k), Table::cell(all.failures[k].empty())};
    for (const double x : all.runs[k]) row.push_back(number(x));
    table.row(std::move(row));
  }
  return table;
}

Table bands_table(const Ensemble& all) {
  auto table = with_spread("column,t");
  for (std::size_t c = 0; c < all.columns.size(); ++c)
    for (std::size_t row = 0; row < all.t.size(); ++row)
      add(table, {all.columns[c], all.t[row]}, all.band(row, c));
  return table;
}

namespace {

using Statement = Database::Statement;

constexpr ListOfRuns lists[] = {{"numbers", "name TEXT, value REAL"}};

}  // namespace

EnsembleStore::EnsembleStore(const std::filesystem::path& file, Database::Access access, StopToken stop)
    : RunStore(file, access,
               {.kind = 3,
                .columns = "run TEXT PRIMARY KEY, start INTEGER, failure TEXT, steps INTEGER, rows BLOB",
                .lists = lists},
               stop) {}

bool EnsembleStore::find(StartOutcome& outcome) const {
  const auto alone = database_.alone();
  Statement s(database_, "SELECT failure, steps, rows FROM runs WHERE run = ?", outcome.key);
  if (!s.step()) return false;
  outcome.failure = s.text(0);
  outcome.steps = s.whole(1);
  outcome.rows = s.doubles(2);
  Statement numbers(database_, "SELECT name, value FROM numbers WHERE run = ?", outcome.key);
  while (numbers.step()) outcome.numbers[numbers.text(0)] = numbers.number(1);
  return true;
}

void EnsembleStore::store(int start, const StartOutcome& outcome) const {
  Database::Transaction whole(database_);
  whole.insert("runs", outcome.key, static_cast<long>(start), outcome.failure, outcome.steps, outcome.rows);
  for (const auto& [name, value] : outcome.numbers) whole.insert("numbers", outcome.key, name, value);
  whole.commit();
}

Identity identity(const Scene& scene, const EnsemblePlan& plan) {
  auto all_starts = identify(scene, plan.formulation, true);
  all_starts.given = fmt::format("seed = {}\nturn = {}\nplay = {}\nrows = {}\n", plan.seed,
                                 toml_number(plan.how.turn), toml_number(plan.how.play), plan.rows);
  for (const auto& value : plan.how.vary)
    all_starts.given += fmt::format("vary = {} {}\n", toml_quoted(value.key), toml_number(value.half));
  for (const auto& column : plan.columns)
    all_starts.given += fmt::format("column = {}\n", toml_quoted(column));
  return all_starts;
}

}  // namespace freeplay
