// The parts of a Simulation, and a run of it in progress. implementation.cpp also runs several
// simulations in lanes (Simulation::run_together()).
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compile/compile.hpp"
#include "dynamics/system.hpp"
#include "facade/simulation.hpp"
#include "formulations/time_stepping/lanes.hpp"
#include "mechanism/scene.hpp"
#include "simulation/clock.hpp"
#include "simulation/formulation.hpp"
#include "simulation/instrument.hpp"
#include "simulation/march.hpp"
#include "simulation/observer.hpp"
#include "simulation/trajectory.hpp"
#include "values/state.hpp"

namespace freeplay {

// The Layout of a simulation: names and sizes of its parts.

/// The layout of a scene's system that starts at this state.
Layout layout_of(const Scene& scene, const System& system, const State& start);

/// Never moved: formulation and sensors refer to scene, system and layout.
struct Simulation::Implementation {
  class Running;
  struct CompileObserver;
  struct RunInProgress;

  Implementation(Scene given, std::string_view formulation, const SimulationOptions& options);

  /// A formulation that starts at this state. Its treatment of the constraint rows depends on the
  /// state.
  std::unique_ptr<Formulation> make_formulation(const State& at) const;
  void save(MemoryWriter& m) {
    m(start.t, start.q, start.v);
    form->save(m);
    m.part("sensors");
    m(sensors);
  }
  void load(const std::vector<std::byte>& memory);
  Identity identity() const;
  std::uint64_t noise_of_run() const;
  void find_undetermined();
  RowFacts facts();
  /// Compiles the mechanism; the run remains bitwise identical. `only_known` and `worth`: as
  /// compile_system().
  void compile_now(const StopToken& stop, bool only_known = false, double worth = longest_estimate);
  /// Compiles it if the run is long enough by now, and so is its rest.
  void compile_if_long(const CompileObserver& run);
  Result summary(const Ending& ending) const;

  Scene scene;
  Family family;
  std::optional<State> given_start;
  System system;
  std::string assumed;  // written by the initialisation of `start`, so declared before it
  State start;
  std::optional<std::vector<double>> restitution;  // from the penalty law, if matched
  Layout layout;
  std::unique_ptr<Formulation> form;
  Sensors sensors;
  Compile compile;
  std::optional<CompiledRun> compiled;  // once it was tried
  std::optional<TracedLanes> lanes;     // once it was in run_together()
  CompiledStructures* structures = nullptr;
  bool looked = false;            // whether they have the structure
  std::optional<bool> redundant;  // whether constraint rows are, at the start; once it was asked
  bool searched = false;
  bool running = false;
  std::vector<std::string> undetermined;
};

/// Refuses run() and restore() while a run of the same simulation is in progress.
class Simulation::Implementation::Running {
 public:
  explicit Running(bool& flag) : flag_(flag) {
    refuse(flag);
    flag_ = true;
  }
  ~Running() { flag_ = false; }
  Running(const Running&) = delete;
  static void refuse(bool flag);

 private:
  bool& flag_;
};

/// Compiles the mechanism after a step, once the run is long enough.
struct Simulation::Implementation::CompileObserver final : Observer, Occasional {
  CompileObserver(Implementation& s, double end, StopToken stop)
      : simulation(s), from(s.form->state().t), until(std::max(end, s.scene.run.duration)), token(stop) {}
  void step(const Step&) override {
    try {
      simulation.compile_if_long(*this);
    } catch (const Interrupted&) {  // the run ends after this step
    }
  }
  double next() const override { return simulation.compiled ? INFINITY : -INFINITY; }
  /// s, CPU time of the rest of the run, if it goes on as before.
  double left() const {
    const double now = simulation.form->state().t;
    return (thread_seconds() - began) * (until - now) / (now - from);
  }
  Implementation& simulation;
  double from, until, began = thread_seconds();
  StopToken token;
};

/// A run in progress: its observers, and the clocks.
struct Simulation::Implementation::RunInProgress {
  RunInProgress(Implementation& s, const RunRequest& request);
  std::vector<Observer*> observers_of(const RunRequest& request);
  Result finish(const Ending& ending);
  /// Time (s) up to which no observer needs steps, except the last one before it.
  double next_shown() const;
  /// LaneRun::follow: the instruments, and `followers`.
  std::function<void(const Step&)> follow(const std::vector<Observer*>& followers = {});

  Implementation& simulation;
  double until;
  EventList list;
  CompileObserver compiler;
  bool every_step = false;                    // whether an observer needs it
  std::vector<const Occasional*> occasional;  // those that need some
  Watch watch;
  Running running;
  std::chrono::steady_clock::time_point wall;
  double cpu = 0;  // s
};

}  // namespace freeplay
