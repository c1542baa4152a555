#include "facade/run_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "facade/assess.hpp"
#include "facade/simulation.hpp"
#include "formulations/contact/steady_film.hpp"
#include "io/files/csv.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/recorded_run.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/files/sealed.hpp"
#include "io/scene/read_scene.hpp"
#include "simulation/bearing_load.hpp"
#include "simulation/film_statistics.hpp"
#include "simulation/observer.hpp"
#include "simulation/pressure_table.hpp"
#include "simulation/statistics.hpp"
#include "values/diagnostic.hpp"
#include "values/snapshot.hpp"

namespace freeplay {
namespace {

constexpr int checkpoint_version = 5;
/// Calls the progress function about 200 times a run.
class ProgressReport final : public Observer, public Occasional {
 public:
  ProgressReport(std::function<void(double)> show, double duration)
      : show_(std::move(show)), duration_(duration) {}
  void step(const Step& step) override {
    if (step.t1 < next_) return;
    next_ = step.t1 + duration_ / 200;
    show_(step.t1 / duration_);
  }
  double next() const override { return next_; }

 private:
  std::function<void(double)> show_;
  double duration_, next_ = 0;
};

/// The result files and the statistics of a run. Owns them; a checkpoint saves their positions.
struct Recorders {
  Recorders(const Simulation& simulation, const std::filesystem::path& folder, bool resumed)
      : statistics(simulation.scene().run.discard),
        windows(simulation.scene().run.discard, simulation.scene().run.duration) {
    const auto& layout = simulation.layout();
    if (!simulation.scene().mechanism.lubricants.empty())
      films.emplace(film_probe(simulation.scene()), simulation.scene().run.discard);
    const auto add = [&](auto& file, const char* name) { file.emplace(folder / name, resumed); };
    add(trajectory, "trajectory.csv");
    if (!layout.contacts.empty() || !layout.families.empty()) add(events, "events.csv");
    if (!layout.channels.empty()) add(signals, "signals.csv");
    if (simulation.scene().run.forces) add(forces, "forces.csv");
    if (!BearingLoadObserver::needed(simulation.scene())) return;
    bearings.emplace(simulation.scene());
    add(pressure, "pressure.csv");
  }
  std::vector<TableCsv*> files() {
    auto list = all_of<TableCsv>();
    if (pressure) list.push_back(&*pressure);
    return list;
  }
  std::vector<RunRows*> tables() { return all_of<RunRows>(); }
  std::vector<std::string> names() {
    std::vector<std::string> list;
    for (auto* file : files()) list.push_back(file->name());
    return list;
  }
  template <class M>
  void serialize(M& m) {
    std::vector<Observer*> all{&statistics, &windows};
    if (films) all.push_back(&*films);
    if (bearings) all.push_back(&*bearings);
    for (auto* table : tables()) all.push_back(table);
    for (auto* observer : all) {
      m.part("observer");
      if constexpr (M::reading)
        observer->load(m);
      else
        observer->save(m);
    }
    if (!pressure) return;
    if constexpr (M::reading)
      pressure->load_from(m);
    else
      pressure->save_to(m);
  }
  /// Adds the pressures of a run that has ended to its result, and writes their file.
  void write_pressures(const Scene& scene, Result& result) {
    if (!bearings) return;
    const auto loads = bearings->loads();
    const auto list = pressures(scene, loads);
    into(result, scene, loads, list);
    const auto table = pressure_table(list);
    pressure->write(table);
  }
  ContactStatistics statistics;
  WindowStatistics windows;
  std::optional<FilmStatistics> films;          ///< in scenes with lubricants
  std::optional<BearingLoadObserver> bearings;  ///< in scenes with wear or an elastic foundation
  std::optional<TrajectoryCsv> trajectory;
  std::optional<EventsCsv> events;
  std::optional<SignalsCsv> signals;
  std::optional<ForcesCsv> forces;
  std::optional<TableCsv> pressure;  ///< with `bearings`, written at the end

 private:
  template <class Base>
  std::vector<Base*> all_of() {
    std::vector<Base*> list{&*trajectory};
    if (events) list.push_back(&*events);
    if (signals) list.push_back(&*signals);
    if (forces) list.push_back(&*forces);
    return list;
  }
};

/// Contents of a checkpoint. The identity determines the run to continue.
struct Checkpoint {
  Identity identity;
  Origin origin;
  double t = 0;
  std::vector<std::byte> memory, recorders;

  template <class M>
  void serialize(M& m) {
    m(identity.scene, identity.formulation, identity.given, identity.program, origin, t, memory, recorders);
  }
  Snapshot snapshot() const { return {t, identity.program, identity.formulation, identity.scene, memory}; }
};

void write_checkpoint(const Simulation& simulation, const RunPlan& plan, Recorders& recorders) {
  auto now = simulation.snapshot();
  Checkpoint c{simulation.identity(), origin_of(simulation.scene()), now.t, std::move(now.memory), {}};
  MemoryWriter of_recorders(c.recorders);
  of_recorders(recorders);
  std::vector<std::byte> bytes;
  MemoryWriter m(bytes);
  m(c);
  write_sealed(*plan.folder / checkpoint_name, "checkpoint", checkpoint_version, bytes);
  for (auto* file : recorders.files()) file->keep();
}

/// Writes checkpoints. Must be the last observer of a run: the recorders have then received the
/// step.
class Checkpoints final : public Observer, public Occasional {
 public:
  Checkpoints(const Simulation& simulation, const RunPlan& plan, Recorders& recorders)
      : simulation_(simulation), plan_(plan), recorders_(recorders), last_(Clock::now()) {}
  void step(const Step& step) override {
    cut_ = step.cut();
    if (!(plan_.checkpoint > 0) || cut_ || step.t1 < next_) return;
    next_ = step.t1 + 64 * (step.t1 - step.t0);
    const auto now = Clock::now();
    if (std::chrono::duration<double>(now - last_).count() < plan_.checkpoint) return;
    write_checkpoint(simulation_, plan_, recorders_);
    last_ = Clock::now();
  }

  /// A stop request arrived while the recorders processed the last step. They have part of it only,
  /// so the run can be continued from the previous checkpoint only.
  bool cut() const { return cut_; }
  double next() const override { return plan_.checkpoint > 0 ? next_ : INFINITY; }

 private:
  using Clock = std::chrono::steady_clock;
  const Simulation& simulation_;
  const RunPlan& plan_;
  Recorders& recorders_;
  Clock::time_point last_;
  double next_ = -INFINITY;  // s, before which the clock is not read
  bool cut_ = false;
};

Result drive(Simulation& simulation, const RunPlan& plan, Recorders& recorders) {
  const auto& folder = *plan.folder;
  ProgressReport progress(plan.on_progress, simulation.scene().run.duration);
  Checkpoints checkpoints(simulation, plan, recorders);
  std::vector<Observer*> observers;
  if (plan.on_progress) observers.push_back(&progress);
  observers.push_back(&recorders.statistics);
  observers.push_back(&recorders.windows);
  if (recorders.films) observers.push_back(&*recorders.films);
  if (recorders.bearings) observers.push_back(&*recorders.bearings);
  for (auto* table : recorders.tables()) observers.push_back(table);
  observers.push_back(&checkpoints);

  auto result = simulation.run({.observers = observers, .most_events = plan.most_events, .stop = plan.stop});
  recorders.statistics.into(result);
  recorders.windows.into(result);
  if (recorders.films) recorders.films->into(result);
  const bool later =
      (plan.checkpoint > 0 || has_checkpoint(folder)) && result.ending.status == Ending::Status::interrupted;
  if (later && !checkpoints.cut()) write_checkpoint(simulation, plan, recorders);
  if (result.ending.status == Ending::Status::interrupted && holds_finished_run(folder)) {
    result.notes.push_back(diagnostic<Diagnostic::finished_run_kept>());
    return result;  // what is to be gone on with stays beside it
  }
  recorders.write_pressures(simulation.scene(), result);
  for (auto* file : recorders.files()) file->settle();
  if (plan.companion)
    add_companion(simulation, {.matched = plan.matched, .start = plan.start, .compile = plan.compile},
                  plan.stop, result);
  auto document = to_json(result);
  document["provenance"] = provenance(simulation.scene(), simulation.identity());
  RunSet set(folder, recorders.names());
  set.summarise(document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  // from here on the folder contains the new run
  for (auto* file : recorders.files()) file->keep();
  set.remove_older();
  for (auto* file : recorders.files()) file->commit();
  set.commit(later);
  return result;
}

}  // namespace

Result run_scene(const Scene& scene, const RunPlan& plan) {
  try {
    Simulation simulation(
        scene, plan.formulation,
        {.matched = plan.matched, .start = plan.start, .stop = plan.stop, .compile = plan.compile});
    if (!plan.folder) {
      ContactStatistics statistics(scene.run.discard);
      ProgressReport progress(plan.on_progress, scene.run.duration);
      std::vector<Observer*> observers{&statistics};
      if (plan.on_progress) observers.push_back(&progress);
      auto result =
          simulation.run({.observers = observers, .most_events = plan.most_events, .stop = plan.stop});
      statistics.into(result);
      if (plan.companion)
        add_companion(simulation, {.matched = plan.matched, .start = plan.start, .compile = plan.compile},
                      plan.stop, result);
      return result;
    }
    if (scene.run.forces) refuse_shared_names(simulation.layout());
    require_room(scene, estimate_output(scene, simulation.state()), plan.runs_alike, *plan.folder,
                 plan.most_output);
    make_folder(*plan.folder);
    const FolderLock lock(*plan.folder, "run");
    settle_run(*plan.folder);
    std::filesystem::remove(*plan.folder / checkpoint_name);  // of the run that is replaced
    Recorders recorders(simulation, *plan.folder, false);
    if (plan.checkpoint > 0) {
      for (auto* table : recorders.tables()) table->begin(simulation.layout(), simulation.state());
      write_checkpoint(simulation, plan, recorders);
    }
    return drive(simulation, plan, recorders);
  } catch (const SceneError&) {
    throw;
  } catch (const ModelError& e) {
    throw located(scene, e);
  }
}

bool has_checkpoint(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::exists(folder / checkpoint_name, ignored);
}

Result resume_run(const std::filesystem::path& folder, const RunPlan& requested) {
  if (!std::filesystem::is_directory(folder))
    throw SnapshotError(
        fmt::format("{}: has no {} to continue from; it is not a folder", folder.string(), checkpoint_name));
  const FolderLock lock(folder, "run --resume");
  settle_run(folder);
  if (!has_checkpoint(folder))
    throw SnapshotError(fmt::format("{}: has no {} to continue from; {}", folder.string(), checkpoint_name,
                                    std::filesystem::exists(folder / "run.json")
                                        ? "its run has ended"
                                        : "give the folder of an interrupted run"));
  const auto bytes = read_sealed(folder / checkpoint_name, "checkpoint", checkpoint_version);
  Checkpoint c;
  auto plan = requested;
  plan.folder = folder;
  const auto refuse = [&](const std::exception& why) {
    return SnapshotError(fmt::format("{}: {}", (folder / checkpoint_name).string(), why.what()));
  };
  try {
    MemoryReader m(bytes);
    m(c);
    const auto snapshot = c.snapshot();
    snapshot.require_program();  // before the scene is read, whose format may be of another version
    auto setup = setup_of(c.identity, c.origin);
    setup.give(plan.outside);
    plan.formulation = setup.formulation;
    plan.matched = setup.matched;
    plan.start = setup.start;
    Simulation simulation(
        setup.scene, plan.formulation,
        {.matched = plan.matched, .start = plan.start, .stop = plan.stop, .compile = plan.compile});
    simulation.restore(snapshot);
    Recorders recorders(simulation, folder, true);
    MemoryReader of_recorders(c.recorders);
    of_recorders(recorders);
    // Change no file before all of them are known to fit. If the partial file is missing, go_on()
    // would continue the finished file in its place. This is correct for this interrupted run, but
    // would damage another run that has ended.
    if (holds_finished_run(folder)) require_halves(folder, recorders.names());
    for (auto* file : recorders.files()) file->go_on();
    return drive(simulation, plan, recorders);
  } catch (const MemoryError& e) {
    throw refuse(e);
  } catch (const SnapshotError& e) {
    throw refuse(e);
  }
}

}  // namespace freeplay
