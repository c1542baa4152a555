#include "study/attractors/attractor_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>
#include <tuple>

#include "analysis/lyapunov.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/toml_text.hpp"
#include "mechanism/magnitude.hpp"
#include "mechanism/scene.hpp"
#include "simulation/section.hpp"
#include "study/runs/perturb.hpp"
#include "values/warning.hpp"

namespace freeplay {
namespace {

using Statement = Database::Statement;

constexpr double greatest_value = 1e45;  // as of forces, the greatest of all plausible ranges

constexpr ListOfRuns lists[] = {{"points", "point INTEGER, t REAL, name TEXT, value REAL"},
                                {"ends", "part TEXT, place INTEGER, value REAL"}};
constexpr ListOfRuns exponents{"exponents", "periods INTEGER, value REAL, error REAL, reason TEXT"};

}  // namespace

AttractorStore::AttractorStore(const std::filesystem::path& file, StopToken stop)
    : RunStore(file, Database::Access::write,
               {.kind = 2,
                .columns =
                    "run TEXT PRIMARY KEY, branch TEXT, x REAL, y REAL, failure TEXT, doubt TEXT, t_end REAL",
                .lists = lists},
               stop) {}

bool AttractorStore::find(const Expected& expected, SettledRun& run) const {
  const auto alone = database_.alone();
  Statement s(database_, "SELECT failure, doubt, t_end FROM runs WHERE run = ?", run.key);
  if (!s.step()) return false;
  const auto require = [&](bool holds, const char* what) {
    if (!holds) database_.refuse(fmt::format("{} of run {:.12} are wrong; it is damaged", what, run.key));
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
  Statement points(database_, "SELECT point, name, t, value FROM points WHERE run = ? ORDER BY rowid",
                   run.key);
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
  Statement ends(database_, "SELECT part, place, value FROM ends WHERE run = ? ORDER BY rowid", run.key);
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

void AttractorStore::store(const SettledRun& run, const std::vector<NamedColumn>& columns) {
  Database::Transaction whole(database_);
  whole.insert("runs", run.key, run.branch, run.values[0],
               run.values.size() > 1 ? run.values[1] : std::nan(""), run.failure, run.doubt, run.end.t);
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    const auto point = i / columns.size();
    whole.insert("points", run.key, static_cast<long>(point), run.t[point], columns[i % columns.size()].name,
                 run.rows[i]);
  }
  const auto put = [&](const std::string& part, const std::vector<double>& list) {
    for (std::size_t i = 0; i < list.size(); ++i)
      whole.insert("ends", run.key, part, static_cast<long>(i), list[i]);
  };
  put("q", run.end.q);
  put("v", run.end.v);
  put("z", run.end.z);
  whole.commit();
}

void AttractorStore::begin_exponents() {
  Database::Transaction whole(database_);  // two processes may begin at the same time
  const auto there = database_.schema();
  for (const auto& definition : definitions_of(exponents))
    if (std::ranges::find(there, definition, &SchemaObject::sql) == there.end())
      database_.execute(definition);
  whole.commit();
}

std::optional<AttractorExponent> AttractorStore::find_exponent(const std::string& key, long periods) const {
  const auto alone = database_.alone();
  const auto found = database_.list<AttractorExponent, double, double, std::string>(
      "SELECT value, error, reason FROM exponents WHERE run = ? AND periods = ?", key, periods);
  return found.empty() ? std::nullopt : std::optional(found.front());
}

void AttractorStore::store_exponent(const std::string& key, long periods, const AttractorExponent& e) {
  Database::Transaction whole(database_);
  whole.insert("exponents", key, periods, e.value, e.error, e.reason);
  whole.commit();
}

namespace {

std::vector<double> drive_angles(const Scene& scene, double t) {
  std::vector<double> angles;
  for (const auto& drive : scene.mechanism.drives) {
    const auto* speed = std::get_if<SpeedDrive>(&drive);
    angles.push_back(speed ? speed->initial_angle + speed->speed * t : std::nan(""));
  }
  return angles;
}

class Settling {
 public:
  Settling(const Study& study, const AttractorPlan& plan, const std::vector<Chain>& chains,
           AttractorStore& store, StopToken stop, const OnProgress& on_progress, SettledRuns& result)
      : study_(study),
        plan_(plan),
        chains_(chains),
        store_(store),
        stop_(stop),
        on_progress_(on_progress),
        r_(result) {
    for (const auto& chain : chains) {
      total_ += chain.links.size();
      r_.chains.emplace_back(chain.links.size());
    }
  }

  Scene scene_of(const ChainLink& link) const { return freeplay::scene_of(study_, plan_, link, stop_); }

  SectionRequest request(const char* table) const {
    const auto of = std::string(table) + ".";
    SectionRequest r{.formulation = plan_.formulation,
                     .section = plan_.section,
                     .columns = plan_.columns,
                     .period = plan_.period ? plan_.period : study_.length.period,
                     .discard = plan_.discard,
                     .keep = plan_.keep,
                     .section_key = of + "section",
                     .column_key = of + "columns",
                     .periods_key = of + "keep"};
    return r;
  }

  /// Resolves a request; errors of the study get their position there.
  SectionPlan plan_of(const Scene& scene, const SectionRequest& requested, const std::string& table) const
      try {
    return SectionSimulation(scene, requested, stop_).plan();
  } catch (const ModelError& e) {
    if (!e.key.starts_with(table + ".")) throw;
    throw error_at(study_, {table, e.key.substr(table.size() + 1)}, e.message);
  }

  void require_exponents_of(const Scene& scene, const char* table) const try {
    require_exponents(scene, plan_.formulation);
  } catch (const ModelError& e) {
    throw error_at(study_, {table, "exponents"}, fmt::format("{}: {}", e.key, e.message));
  }

  /// Reads all scenes; assembles the first one of each chain, which determines the columns.
  void check(const char* table) {
    auto requested = request(table);
    for (const auto& chain : chains_)
      for (std::size_t i = 0; i < chain.links.size() && !stop_(); ++i) {
        const bool first = r_.columns.empty();
        auto plain = chain.links[i];
        if (!first) plain.start = -1;
        const auto scene = scene_of(plain);
        if (plan_.exponents) require_exponents_of(scene, table);
        if (chain.links[i].start > 0 && !differ(scene, study_.starts.perturbation))
          throw error_at(
              study_, {table, "starts"},
              fmt::format("{}: all starts are identical: it has no drive of prescribed speed and no joint "
                          "with clearance",
                          study_.scene.string()));
        if (!first) continue;
        auto plan = plan_of(scene, requested, table);
        if (requested.columns.empty()) {
          requested.columns = plan.shown;
          plan = plan_of(scene, requested, table);
        }
        r_.columns = plan.columns;
        r_.period = plan.period;
        compilation_.duration = plan.until;
      }
    requested_ = requested;
    for (const auto& c : r_.columns) r_.likeness.circles.push_back(c.column.circle());
    r_.likeness.tolerance = plan_.tolerance;
    r_.likeness.most = plan_.most_period;
  }

  void run(int threads) {
    compilation_.runs = total_;
    for (std::size_t chain = 0; chain < chains_.size(); ++chain) waiting_.push_back({chain});
    execute(
        threads, chains_.size(), stop_, [&] { return next_run(); },
        [&](StudyRun& run) { keep(static_cast<Run&>(run)); });
    r_.interrupted = stop_();
  }

 private:
  /// How far a chain is.
  struct Along {
    std::size_t chain = 0, link = 0;
    std::optional<Handed> handed = {};
  };
  /// The run of a link.
  struct Run final : SectionSimulation {
    Run(const Scene& s, const SectionRequest& request, const StopToken& stop, SharedCompilation& compilation)
        : SectionSimulation(s, request, stop, &compilation), angles_at_end(drive_angles(s, plan().until)) {}
    Along along;
    std::vector<double> angles_at_end;
  };

  std::unique_ptr<StudyRun> next_run() {
    while (!stop_()) {
      Along along;
      {
        const std::lock_guard lock(mutex_);
        if (waiting_.empty()) break;
        along = std::move(waiting_.front());
        waiting_.pop_front();
      }
      if (auto run = next_of(along)) return run;
    }
    return nullptr;
  }

  /// The next run of a chain that is not stored; null at the end of the chain.
  std::unique_ptr<StudyRun> next_of(Along& along) {
    const auto& chain = chains_[along.chain];
    for (; along.link < chain.links.size() && !stop_(); ++along.link) {
      const auto& link = chain.links[along.link];
      auto& made = r_.chains[along.chain][along.link];
      auto scene = scene_of(link);
      auto requested = requested_;
      if (along.handed)
        requested.start = located_in(scene, [&] { return take_over(scene, *along.handed, stop_); });
      auto run = std::make_unique<Run>(scene, requested, stop_, compilation_);
      made.key = key_of(chain, link, *run);
      made.branch = chain.branch;
      made.values = link.values;
      const auto& start = run->simulation().state();
      const bool there = store_.find({r_.columns, start.q.size(), start.z.size(), run->plan().until}, made);
      made.period = run->plan().period;
      made.drive_angles = run->angles_at_end;
      if (!there) {
        run->along = std::move(along);
        return run;
      }
      hand_over(along, made, *run);
      finish_one(made, r_.found);
    }
    return nullptr;
  }

  /// Keeps the result of a run, after which its chain goes on.
  void keep(Run& one) {
    auto& run = one.made();
    if (run.ending.status == Ending::Status::interrupted) return;
    auto along = std::move(one.along);
    auto& made = r_.chains[along.chain][along.link];
    made.failure = run.ending.status == Ending::Status::failed ? run.ending.reason : "";
    for (const auto& note : run.notes)
      if (is_warning(note)) made.doubt += (made.doubt.empty() ? "" : "; ") + note;
    made.t = std::move(run.t);
    made.rows = std::move(run.rows);
    made.end = std::move(run.end);
    store_.store(made, r_.columns);
    hand_over(along, made, one);
    ++along.link;
    finish_one(made, r_.made);
    const std::lock_guard lock(mutex_);
    r_.in_lanes += one.in_lanes;
    waiting_.push_front(std::move(along));
  }

  /// After a failed run, the next value starts from the end of the last finished one.
  static void hand_over(Along& along, const SettledRun& made, const Run& run) {
    if (made.finished()) along.handed = Handed{made.end, run.angles_at_end};
  }
  void finish_one(SettledRun& made, std::size_t& count) {
    made.attractor = attractor_of(made.rows, r_.likeness);
    const std::lock_guard lock(mutex_);
    ++count;
    ++done_;
    if (on_progress_) on_progress_(done_, total_);
  }

  std::string key_of(const Chain& chain, const ChainLink& link, const Run& run) const {
    auto lines = fmt::format("branch = {}\nvalues = {}\nsection = {}\nuntil = {}\ndiscard = {}\n",
                             toml_quoted(chain.branch), toml_numbers(link.values), toml_quoted(plan_.section),
                             toml_number(run.plan().until), toml_number(run.plan().discard));
    for (const auto& column : requested_.columns) lines += fmt::format("column = {}\n", toml_quoted(column));
    return run_key(run.identity(), lines);
  }

  const Study& study_;
  const AttractorPlan& plan_;
  const std::vector<Chain>& chains_;
  AttractorStore& store_;
  StopToken stop_;
  const OnProgress& on_progress_;
  SettledRuns& r_;
  SectionRequest requested_;
  std::size_t total_ = 0, done_ = 0;
  SharedCompilation compilation_;
  std::mutex mutex_;           // guards the counts of the results, and the following
  std::deque<Along> waiting_;  // chains, for their next runs: first those that have begun
};

}  // namespace

State take_over(Scene& scene, const Handed& from, const StopToken& stop) {
  for (std::size_t i = 0; i < scene.mechanism.drives.size() && i < from.drive_angles.size(); ++i)
    if (auto* speed = std::get_if<SpeedDrive>(&scene.mechanism.drives[i]);
        speed && !std::isnan(from.drive_angles[i]))
      speed->initial_angle = from.drive_angles[i];
  auto mechanism = scene.mechanism;
  start_from(mechanism, from.state);
  mechanism.assembly.approximate = true;  // the state satisfied the constraints of other values
  auto state = assemble(mechanism, RunOptions::Start::assembled, nullptr, stop);
  state.t = 0;
  if (from.state.z.size() == state.z.size() || state.z.empty()) state.z = from.state.z;
  return state;
}

Scene scene_of(const Study& study, const AttractorPlan& plan, const ChainLink& link,
               const StopToken& stop) try {
  auto overrides = plan.overrides;
  overrides.insert(overrides.end(), link.overrides.begin(), link.overrides.end());
  auto scene = read_scene(study.scene, overrides, study.reach == Reach::anywhere);
  if (link.start >= 0 && differ(scene, study.starts.perturbation))
    scene = perturbed(scene, stop, study.starts.seed, link.start, study.starts.perturbation);
  return scene;
} catch (const SceneError& e) {
  throw in_study(study, e);
}

SettledRuns settle(const Study& study, const AttractorPlan& plan, const char* table,
                   const std::vector<Chain>& chains, AttractorStore& store, int threads, StopToken stop,
                   const OnProgress& on_progress) {
  SettledRuns result;
  Settling settling(study, plan, chains, store, stop, on_progress, result);
  settling.check(table);
  if (!stop()) settling.run(threads);
  result.interrupted = stop();
  return result;
}

std::vector<std::string> settings_at(const Axis& axis, std::size_t place) {
  std::vector<std::string> list{fmt::format("{}={}", axis.key, axis.values[place])};
  for (std::size_t k = 0; k < axis.others.size(); ++k)
    list.push_back(fmt::format("{}={}", axis.others[k], axis.other_values[k][place]));
  return list;
}

}  // namespace freeplay
