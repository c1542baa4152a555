#include "study/wear/wear_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>

#include "io/files/digest.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/toml_text.hpp"
#include "mechanism/scene.hpp"
#include "study/wear/worn_profile.hpp"

namespace freeplay {
namespace {

/// One run of a set.
class WearingRun final : public StudyRun {
 public:
  /// `joints`: those that wear; `slot`: its place in the set.
  WearingRun(Scene scene, const std::string& formulation, SimulationOptions options,
             const std::vector<std::string>& joints, std::size_t slot, std::string key)
      : place(slot),
        joints_(joints),
        scene_(std::move(scene)),
        simulation_(scene_, formulation, options),
        observer_(scene_),
        stop_(options.stop) {
    outcome.key = std::move(key);
  }
  Simulation& simulation() override { return simulation_; }
  RunRequest request() override {
    return {.until = scene_.run.duration, .observers = {&observer_}, .keep_events = false, .stop = stop_};
  }
  double next_shown() const override { return -INFINITY; }
  bool take(Result result) override {
    outcome.interrupted = result.ending.status == Ending::Status::interrupted;
    outcome.steps = result.work.steps;
    if (result.ending.status == Ending::Status::finished) {
      for (auto& joint : observer_.loads())
        if (std::ranges::find(joints_, joint.joint) != joints_.end()) loads.push_back(std::move(joint));
    } else {
      outcome.failure = result.ending.reason.empty() ? "did not finish" : result.ending.reason;
    }
    return false;
  }

  std::size_t place;
  StartOutcome outcome;
  std::vector<BearingLoads> loads;

 private:
  const std::vector<std::string>& joints_;
  Scene scene_;
  Simulation simulation_;
  BearingLoadObserver observer_;
  StopToken stop_;
};

/// A digest of the surfaces of all joints, bit for bit.
std::string form_of(const std::vector<WornBearing>& surfaces) {
  std::string text;
  for (const auto& s : surfaces)
    for (const auto* form : {&s.bearing_form(), &s.journal_form()})
      text += fmt::format("{} [{}]\n", s.joint().name, toml_numbers(*form));
  return digest(text);
}

Case case_of(const Study& study, const std::string& formulation) {
  return {.variant = "wear",
          .formulation = formulation,
          .values = {},
          .start = 0,
          .revolutions = study.length.revolutions,
          .scene = study.scene,
          .overrides = study.wear->overrides};
}

/// The wear of one formulation.
class WearingFormulation {
 public:
  WearingFormulation(const Study& study, const Conduct& conduct, EnsembleStore& store, int threads,
                     const std::string& formulation, WearStudy& all,
                     const std::function<void(const WearProgress&)>& on_progress)
      : study_(study),
        conduct_(conduct),
        store_(store),
        threads_(threads),
        formulation_(formulation),
        all_(all),
        on_progress_(on_progress) {
    case_ = case_of(study, formulation);
    identity_ = identity(study, case_, conduct);
    const auto scene = scene_of(study, case_, conduct);
    joints_ = wearing_joints(scene, static_cast<std::size_t>(study.wear->points));
    for (const auto& joint : joints_) names_.push_back(joint.joint().name);
    differ_ = has_starts(study, case_);
    starts_ = differ_ ? static_cast<std::size_t>(study.starts.count) : 1;
    progress_.formulation = formulation;
    progress_.runs = starts_;
    const auto time = counted_time(study, scene);
    all.has_period = time.period > 0;
    all.turn = all.has_period ? time.period : time.to - time.from;
    all.simulated = (time.to - time.from) / all.turn;
    all.starts = static_cast<int>(starts_);
    all.lengths.clear();
    for (const auto& joint : joints_) all.lengths.push_back(joint.joint().foundation.length);
  }

  WearHistory run() {
    const auto& plan = *study_.wear;
    const WearLimits limits{plan.turns.value_or(WearLimits::none), plan.depth.value_or(WearLimits::none),
                            plan.clearance.value_or(WearLimits::none), plan.share,
                            plan.longest.value_or(WearLimits::none)};
    WearHistory history{formulation_, {}, WearEnd::turns, 0};
    const auto ended_by = [&](const std::exception& e) {
      if (history.cycles.size() < 2)  // nothing is worn yet
        throw SceneError(fmt::format("{}: {}: {}", study_.file.string(), formulation_, e.what()));
      all_.failures.push_back(fmt::format("{}: {}", formulation_, e.what()));
      history.end = WearEnd::failed;
    };
    try {
      history.end = wear_cycles(
          joints_, limits, all_.simulated,
          [&](const std::vector<WornBearing>& surfaces, int set) { return loads(surfaces, set, history); },
          [&](const WearCycle& cycle) {
            history.cycles.push_back(cycle);
            progress_.turns = cycle.turns;
            progress_.share = way(cycle, limits);
          },
          [&] { show_progress(); });
    } catch (const WearStopped& e) {
      ended_by(e);
    } catch (const NoEquilibrium& e) {
      ended_by(e);
    }
    return history;
  }

 private:
  void show_progress() const {
    if (on_progress_) on_progress_(progress_);
  }

  static double way(const WearCycle& cycle, const WearLimits& limits) {
    double share = cycle.turns / limits.turns;
    for (const auto& j : cycle.joints) {
      const double c = j.bearing.joint().foundation.clearance;
      share = std::max({share, j.in_bearing.depth / limits.depth, j.in_journal.depth / limits.depth});
      if (limits.clearance < WearLimits::none)
        share = std::max(share, (j.bearing.measured_clearance() - c) / (limits.clearance - c));
    }
    return std::min(share, 1.0);
  }

  std::vector<TurnLoads> loads(const std::vector<WornBearing>& surfaces, int set, WearHistory& history) {
    const auto lines = fmt::format("wear = \"{}\"\n", form_of(surfaces));
    std::vector<std::vector<BearingLoads>> outcomes(starts_);  // of each start
    std::vector<std::string> failures(starts_);
    std::mutex guard;
    std::size_t next_place = 0;
    progress_.set = set;
    progress_.done = 0;
    show_progress();
    const auto ended = [&] {
      ++progress_.done;
      show_progress();
    };
    double rounding = 0;
    SharedCompilation compilation;
    compilation.runs = starts_;
    const auto next = [&]() -> std::unique_ptr<StudyRun> {
      while (!conduct_.stop()) {
        std::size_t place = 0;
        StartOutcome outcome;
        {
          const std::lock_guard lock(guard);
          place = next_place++;
          if (place >= starts_) break;
          const auto start = start_of(set, place);
          outcome.key = run_key(identity_, fmt::format("{}start = {}\n", lines, start));
          if (store_.find(outcome)) {
            if (outcome.failure.empty()) outcomes[place] = unpacked(outcome.rows, names_);
            failures[place] = outcome.failure;
            ++all_.found;
            ended();
            continue;
          }
        }
        auto own = case_;
        own.start = start_of(set, place);
        try {
          auto scene = scene_of(study_, own, conduct_);
          double changed = 0;
          for (const auto& s : surfaces) changed = std::max(changed, set_worn(scene.mechanism, s));
          auto options = compilation.options(scene, formulation_);
          options.matched = study_.matched && conduct_.matched;
          options.stop = conduct_.stop;
          auto run = std::make_unique<WearingRun>(std::move(scene), formulation_, options, names_, place,
                                                  outcome.key);
          const std::lock_guard lock(guard);
          rounding = std::max(rounding, changed);
          return run;
        } catch (const SceneError&) {
          throw;
        } catch (const ModelError& e) {
          const std::lock_guard lock(guard);
          failures[place] = e.what();
          ended();
        }
      }
      return nullptr;
    };
    execute(threads_, starts_, conduct_.stop, next, [&](StudyRun& made) {
      auto& run = static_cast<WearingRun&>(made);
      if (run.outcome.interrupted) return;
      run.outcome.rows = packed(run.loads);
      const std::lock_guard lock(guard);
      store_.store(start_of(set, run.place), run.outcome);
      outcomes[run.place] = std::move(run.loads);
      failures[run.place] = run.outcome.failure;
      ++all_.made;
      ended();
    });
    if (conduct_.stop()) throw Interrupted();
    history.rounding = std::max(history.rounding, rounding_of(surfaces, rounding));
    return together(outcomes, failures, set);
  }

  /// That of the surfaces; also if all runs came from the store.
  double rounding_of(const std::vector<WornBearing>& surfaces, double known) const {
    if (known > 0) return known;
    auto mechanism = scene_of(study_, case_, conduct_).mechanism;
    for (const auto& s : surfaces) known = std::max(known, set_worn(mechanism, s));
    return known;
  }

  std::vector<TurnLoads> together(const std::vector<std::vector<BearingLoads>>& outcomes,
                                  const std::vector<std::string>& failures, int set) {
    std::vector<TurnLoads> all;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      std::vector<BearingLoads> starts;
      for (const auto& outcome : outcomes)
        if (!outcome.empty()) starts.push_back(outcome[j]);
      if (2 * starts.size() < starts_ || starts.empty()) {
        const auto& reason = *std::ranges::find_if(failures, [](const auto& f) { return !f.empty(); });
        if (set == 0) throw SceneError(fmt::format("{}: {}", study_.file.string(), reason));
        throw WearStopped(fmt::format("{} of {} runs with worn surfaces (set {}) fail: {}",
                                      starts_ - starts.size(), starts_, set, reason));
      }
      all.push_back(united(starts, all_.simulated));
    }
    for (std::size_t k = 0; k < failures.size(); ++k)
      if (!failures[k].empty())
        all_.failures.push_back(
            fmt::format("{}, set {}, start {}: {}", formulation_, set, start_of(set, k), failures[k]));
    return all;
  }

  int start_of(int set, std::size_t place) const {
    return differ_ ? set * static_cast<int>(starts_) + static_cast<int>(place) : 0;
  }

  const Study& study_;
  const Conduct& conduct_;
  EnsembleStore& store_;
  int threads_;
  std::string formulation_;
  WearStudy& all_;
  const std::function<void(const WearProgress&)>& on_progress_;
  WearProgress progress_;
  Case case_;
  Identity identity_;
  std::vector<WornBearing> joints_;
  std::vector<std::string> names_;
  bool differ_ = false;
  std::size_t starts_ = 1;
};

}  // namespace

std::vector<WornBearing> wearing_joints(const Scene& scene, std::size_t points) {
  const auto& mechanism = scene.mechanism;
  std::vector<WornBearing> list;
  for (const auto& joint : mechanism.joints) {
    const auto* revolute = std::get_if<RevoluteJoint>(&joint);
    if (!revolute || !revolute->clearance || !revolute->clearance->wears()) continue;
    const auto& c = *revolute->clearance;
    const auto foundation = located_in(scene, [&] { return foundation_of(mechanism, *revolute); });
    auto bearing = polar_deviations(mechanism, c.bearing_profile, foundation.bearing_radius, points);
    if (bearing.empty()) bearing.assign(points, 0.0);
    list.emplace_back(
        WearingJoint{revolute->name, foundation, c.bearing_wear.value_or(0), c.journal_wear.value_or(0),
                     std::move(bearing),
                     polar_deviations(mechanism, c.journal_profile, foundation.journal_radius(), points)});
  }
  const bool any = std::ranges::any_of(
      list, [](const WornBearing& b) { return b.joint().bearing > 0 || b.joint().journal > 0; });
  if (!any)
    throw SceneError(
        fmt::format("{}: no joint wears: give a revolute joint with clearance bearing_wear or "
                    "journal_wear (m²/N) greater than 0, and bearing_length",
                    scene.file.string()));
  std::erase_if(list, [](const WornBearing& b) { return !(b.joint().bearing > 0 || b.joint().journal > 0); });
  return list;
}

std::vector<double> packed(const std::vector<BearingLoads>& loads) {
  std::vector<double> row;
  for (const auto& joint : loads) {
    row.insert(row.end(), {joint.merged ? 1.0 : 0.0, static_cast<double>(joint.loads.size()),
                           static_cast<double>(joint.work_of_turns.size())});
    for (const auto& l : joint.loads)
      row.insert(row.end(),
                 {l.on_bearing, l.on_journal, l.width_on_bearing, l.width_on_journal, l.force, l.work});
    row.insert(row.end(), joint.work_of_turns.begin(), joint.work_of_turns.end());
  }
  return row;
}

std::vector<BearingLoads> unpacked(const std::vector<double>& row, const std::vector<std::string>& joints) {
  std::size_t at = 0;
  const auto damaged = [] { return SceneError("wear.db: the loads of a run are damaged; remove the file"); };
  // Within [low, high].
  const auto next = [&](double low, double high) {
    if (at >= row.size() || !(row[at] >= low && row[at] <= high)) throw damaged();
    return row[at++];
  };
  constexpr double greatest = 1e45, whole_turn = 2 * std::numbers::pi;
  const auto count = [&] { return static_cast<std::size_t>(next(0, static_cast<double>(row.size()))); };
  std::vector<BearingLoads> list;
  for (const auto& name : joints) {
    BearingLoads joint;
    joint.joint = name;
    joint.merged = next(0, 1) > 0;
    const auto loads = count(), turns = count();
    for (std::size_t i = 0; i < loads; ++i) {
      BearingLoad l;
      for (double* angle : {&l.on_bearing, &l.on_journal}) *angle = next(-whole_turn, whole_turn);
      for (double* width : {&l.width_on_bearing, &l.width_on_journal}) *width = next(0, whole_turn);
      for (double* value : {&l.force, &l.work}) *value = next(0, greatest);
      joint.loads.push_back(l);
    }
    for (std::size_t i = 0; i < turns; ++i) joint.work_of_turns.push_back(next(0, greatest));
    list.push_back(std::move(joint));
  }
  if (at != row.size()) throw damaged();
  return list;
}

void require_wear(const Study& study, const Conduct& conduct) {
  const auto& plan = *study.wear;
  for (const auto& formulation : study.formulations) {
    const auto one = case_of(study, formulation);
    const auto scene = scene_of(study, one, conduct);
    const auto joints = wearing_joints(scene, static_cast<std::size_t>(plan.points));
    counted_time(study, scene);
    using Limit = std::pair<const char*, std::optional<double>>;
    for (const auto& joint : joints)
      for (const auto& [key, limit] :
           {Limit("clearance", plan.clearance), Limit("life_clearance", plan.life_clearance)})
        if (const double c = joint.measured_clearance(); limit && *limit <= c)
          throw error_at(
              study, {"wear", key},
              fmt::format("must be greater than the clearance {} of joint {} at the beginning, is {}", c,
                          joint.joint().name, *limit));
    require_runnable(study, one, conduct);
  }
}

WearStudy wear_study(const Study& study, const Conduct& conduct, EnsembleStore& store, int threads,
                     const std::function<void(const WearProgress&)>& on_progress) {
  const auto began = std::chrono::steady_clock::now();
  WearStudy all;
  try {
    for (const auto& formulation : study.formulations)
      all.histories.push_back(
          WearingFormulation(study, conduct, store, threads, formulation, all, on_progress).run());
  } catch (const Interrupted&) {
    all.interrupted = true;
  }
  all.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return all;
}

}  // namespace freeplay
