#include "study/ensemble/ensemble.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <set>

#include "facade/compile.hpp"
#include "facade/simulation.hpp"
#include "io/files/visible.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "simulation/clock.hpp"
#include "simulation/columns.hpp"
#include "simulation/statistics.hpp"
#include "simulation/windows.hpp"
#include "study/runs/measurer.hpp"
#include "study/runs/near_pose.hpp"

namespace freeplay {
namespace {

constexpr double most_bytes = 2e9;

/// Observer that records chosen columns at given times.
class Sampled final : public Observer {
 public:
  Sampled(const std::vector<Column>& columns, const std::vector<double>& times, double* rows)
      : columns_(columns), times_(times), rows_(rows) {}

  void begin(const Layout& layout, const State& state) override {
    q_.resize(state.q.size());
    v_.resize(state.v.size());
    contacts_.resize(layout.contacts.size());
    for (const auto& c : columns_) places_ |= c.of == Column::Of::contact;
  }
  /// Time (s) before which no step is recorded.
  double next() const { return next_ < times_.size() ? times_[next_] - slack() : INFINITY; }
  void step(const Step& step) override {
    const double slack = this->slack();
    for (; next_ < times_.size() && times_[next_] <= step.t1 + slack; ++next_) {
      const double t = std::clamp(times_[next_], step.t0, step.t1);
      step.state(t, q_, v_);
      if (places_) step.contacts(t, q_, contacts_);
      for (const auto& c : columns_) *rows_++ = value(c, t);
    }
  }

 private:
  /// The last time may exceed the end of the last step by rounding.
  double slack() const { return 1e-12 * times_.back(); }
  double value(const Column& c, double t) const {
    switch (c.of) {
      case Column::Of::position:
        return q_[c.index];
      case Column::Of::velocity:
        return v_[c.index];
      case Column::Of::contact:
        return contacts_[c.index].*c.place;
      default:
        return t;
    }
  }

  const std::vector<Column>& columns_;
  const std::vector<double>& times_;
  double* rows_;
  std::size_t next_ = 0;
  bool places_ = false;
  std::vector<double> q_, v_;
  std::vector<ContactPlace> contacts_;
};

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
  require_differing_starts(scene, plan.how);
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
  near_ = near_pose(scene, plan.stop);
}

/// One start: its simulation and observers.
struct Starts::Run {
  /// `like`: a simulation of another start, or null.
  Run(const Starts& all, int start, Compile compile, const Simulation* like = nullptr)
      : scene(perturbed(all.scene_, all.near_, all.plan_.stop, all.plan_.seed, start, all.plan_.how)),
        simulation(
            scene, all.plan_.formulation,
            {.matched = true, .stop = all.plan_.stop, .compile = compile, .like = like, .checked = true}),
        rows(all.times_.size() * all.columns_.size(), std::nan("")),
        sampled(all.columns_, all.times_, rows.data()),
        contacts(scene.run.discard),
        window(scene.run.discard, scene.run.duration) {}
  Run(const Run&) = delete;
  RunRequest request(const StopToken& stop) {
    return {.observers = {&contacts, &window, &sampled}, .keep_events = false, .stop = stop};
  }
  StartOutcome outcome(Result run) {
    StartOutcome out;
    out.rows = std::move(rows);
    out.interrupted = run.ending.status == Ending::Status::interrupted;
    if (run.ending.status != Ending::Status::finished) {
      out.failure = run.ending.reason.empty() ? "did not finish" : run.ending.reason;
    } else {
      contacts.into(run);
      window.into(run);
      out.numbers = numbers_of(run);
      std::erase_if(out.numbers,
                    [](const auto& n) { return !std::isfinite(n.second) || of_the_machine(n.first); });
    }
    out.steps = run.work.steps;
    return out;
  }

  Scene scene;
  Simulation simulation;
  std::vector<double> rows;
  Sampled sampled;
  ContactStatistics contacts;
  WindowStatistics window;
};

namespace {

/// The outcome of f(), or of what it throws.
template <class F>
StartOutcome outcome_of(F f) {
  StartOutcome out;
  try {
    out = f();
  } catch (const Interrupted&) {
    out.interrupted = true;
    out.failure = "interrupted";
  } catch (const ModelError& e) {
    out.failure = e.what();
  }
  return out;
}

/// Right-hand sides of all starts together above which lanes are worth their compilations.
constexpr double lanes_after = 1e6;
/// Steps of the starts that one thread makes before their results are kept.
constexpr double steps_in_group = 1e7;

}  // namespace

StartOutcome Starts::make(int start) const {
  const double began = thread_seconds();
  auto out = outcome_of([&] {
    Run run(*this, start, Compile::automatic);
    return run.outcome(run.simulation.run(run.request(plan_.stop)));
  });
  out.cpu_seconds = thread_seconds() - began;
  return out;
}

Starts::~Starts() = default;

const Simulation& Starts::model() const {
  std::call_once(model_made_, [&] {
    model_ = std::make_unique<const Simulation>(
        scene_, plan_.formulation,
        SimulationOptions{.matched = true, .stop = plan_.stop, .compile = Compile::always});
  });
  return *model_;
}

std::size_t Starts::in_group() const {
  const auto& o = scene_.nonsmooth;
  const auto choice = compile_choice(Compile::automatic);
  if (plan_.formulation != "nonsmooth" || choice == Compile::never || !o.step ||
      o.scheme_in_force() != Scheme::moreau_jean)
    return 1;
  const double steps = scene_.run.duration / *o.step;
  if (choice != Compile::always && steps * plan_.starts < lanes_after) return 1;
  const int lanes = Simulation::most_together(),
            threads = plan_.threads > 0 ? plan_.threads : oneapi::tbb::this_task_arena::max_concurrency();
  // Several for each lane, so that no lane stays empty while others run, as long as no thread waits
  const double rounds = std::min(plan_.starts / (2.0 * threads * lanes), steps_in_group / (steps * lanes));
  return static_cast<std::size_t>(lanes * std::clamp(static_cast<int>(rounds), 1, 8));
}

std::vector<StartOutcome> Starts::make_together(const std::vector<int>& starts) const {
  if (starts.size() == 1) return {make(starts.front())};
  const double began = thread_seconds();
  std::vector<StartOutcome> outcomes(starts.size());
  std::vector<std::unique_ptr<Run>> runs(starts.size());
  std::vector<Simulation::Together> all;
  const Simulation* like = nullptr;
  for (std::size_t i = 0; i < starts.size(); ++i)
    outcomes[i] = outcome_of([&] {
      runs[i] = std::make_unique<Run>(*this, starts[i], Compile::always, like ? like : &model());
      auto& run = *runs[i];
      if (!like) like = &run.simulation;
      all.push_back({&run.simulation, run.request(plan_.stop),
                     [&run] { return std::min(run.window.next(), run.sampled.next()); }});
      return StartOutcome();
    });
  if (all.empty()) return outcomes;
  long in_lanes = 0;
  auto results = Simulation::run_together(all, in_lanes);
  double steps = 0;
  for (std::size_t i = 0, next = 0; i < starts.size(); ++i) {
    if (!runs[i]) continue;
    outcomes[i] = outcome_of([&] { return runs[i]->outcome(std::move(results[next++])); });
    steps += static_cast<double>(outcomes[i].steps);
  }
  for (auto& out : outcomes) {
    out.cpu_seconds = (thread_seconds() - began) / static_cast<double>(starts.size());
    if (steps > 0) out.in_lanes = static_cast<double>(in_lanes) * static_cast<double>(out.steps) / steps;
  }
  return outcomes;
}

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

void Starts::make_all(const std::vector<int>& starts,
                      const std::function<bool(std::size_t, StartOutcome&)>& find,
                      const std::function<void(std::size_t, StartOutcome&, bool)>& done) const {
  std::mutex guard;
  const auto width = in_group();
  const auto groups = (starts.size() + width - 1) / width;
  oneapi::tbb::task_arena arena(plan_.threads > 0 ? plan_.threads : oneapi::tbb::task_arena::automatic);
  arena.execute([&] {
    oneapi::tbb::parallel_for(std::size_t{0}, groups, [&](std::size_t group) {
      if (plan_.stop()) return;
      std::vector<std::size_t> places;
      std::vector<int> list;
      for (auto place = group * width; place < std::min((group + 1) * width, starts.size()); ++place) {
        const std::lock_guard lock(guard);
        StartOutcome outcome;
        if (find(place, outcome)) {
          done(place, outcome, true);
        } else {
          places.push_back(place);
          list.push_back(starts[place]);
        }
      }
      if (list.empty()) return;
      auto outcomes = make_together(list);
      const std::lock_guard lock(guard);
      for (std::size_t i = 0; i < places.size(); ++i) done(places[i], outcomes[i], false);
    });
  });
}

Ensemble run_ensemble(const Scene& scene, const EnsemblePlan& plan,
                      const std::function<void(double)>& on_progress, const KnownStarts& known) {
  const auto began = std::chrono::steady_clock::now();
  const Starts starts(scene, plan);
  std::vector<int> list(static_cast<std::size_t>(plan.starts));
  std::iota(list.begin(), list.end(), 0);
  std::vector<StartOutcome> outcomes(list.size());
  int done = 0;
  starts.make_all(
      list, [&](std::size_t place, StartOutcome& outcome) { return known && known(list[place], outcome); },
      [&](std::size_t place, StartOutcome& outcome, bool) {
        outcomes[place] = std::move(outcome);
        if (on_progress) on_progress(static_cast<double>(++done) / plan.starts);
      });
  auto all = starts.together(outcomes);
  all.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return all;
}

}  // namespace freeplay
