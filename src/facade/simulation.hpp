// Simulation: integration of one scene in one formulation, and its parameters. This is the central
// class of the public interface (freeplay.hpp).
//
// A Simulation assembles the start, then advances the state by the solver of its formulation: the
// integrators of the penalty formulation (docs/theory/penalty.md), or event-driven integration and
// time stepping of the nonsmooth formulation (docs/theory/nonsmooth.md). Symbols are those of
// docs/theory/notation.md.
//
// It owns a copy of the scene, the equations of motion, the formulation with its state, and the
// models of the instruments. It does not own observers or stop flags: these must outlive the run
// that uses them. The header exposes no internal type, so user code depends on the value types
// only.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "simulation/observer.hpp"
#include "values/compile.hpp"
#include "values/identity.hpp"
#include "values/ledger.hpp"
#include "values/result.hpp"
#include "values/snapshot.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

class CompiledStructures;
struct Scene;

/// Options of a Simulation that the scene does not contain.
struct SimulationOptions {
  /// Whether contacts of the nonsmooth formulation take the coefficient of restitution that the
  /// scene's penalty law delivers in a free impact, instead of the surfaces' values. The penalty
  /// formulation ignores this option. Not available with a caller's own contact law, whose
  /// restitution is unknown (ModelError).
  bool matched = false;
  /// Start of the run; if absent, it is assembled as the scene's `run.start` requires. It must
  /// satisfy the constraints. `q` and `v` have 3 entries for each body; an empty `z` sets all
  /// first-order states to 0.
  std::optional<State> start = {};
  /// Stop request during the assembly of the start: the constructor then throws Interrupted. Runs
  /// have a token of their own, RunRequest::stop.
  StopToken stop = {};
  /// When it compiles its mechanism; `automatic` obeys the environment variable FREEPLAY_COMPILE.
  Compile compile = Compile::automatic;
  /// Compiled functions that it shares with others of the same structure, such as the runs of a study;
  /// not owned.
  CompiledStructures* structures = nullptr;
  /// Whether the caller guarantees that the scene satisfies the rules of parse_scene(): it has been read,
  /// and only start, drives' initial angles or run were changed since. Otherwise the constructor
  /// applies the rules to the facts in memory.
  bool checked = false;
};

/// Parameters of one call of Simulation::run().
struct RunRequest {
  /// End of the run, s; must not precede the current time. Default: the scene's duration. The last
  /// step is cut to end exactly here.
  std::optional<double> until = {};
  /// Observers, not owned. Each accepted step is passed to them in this order, after the instrument
  /// samples that lie in it.
  std::vector<Observer*> observers = {};
  bool keep_events = true;  ///< whether Result::events is filled
  /// Maximum number of events in Result::events; Result::events_cut() reports whether there were
  /// more.
  std::size_t most_events = 1'000'000;
  /// Stop request: the run ends after the current step, and run() can continue it later.
  StopToken stop = {};
};

/// One scene in one formulation, with its current state. Simulations are independent; each is used
/// by one thread at a time. Movable, not copyable: copy a state with snapshot() and restore().
class Simulation {
 public:
  /// Copies the scene and assembles the start.
  ///
  /// `formulation` is "penalty" or "nonsmooth". Throws ModelError if the scene is invalid, if its
  /// start cannot be assembled, or if the formulation or the options are not applicable. Throws
  /// Interrupted if `options.stop` requests it.
  Simulation(Scene scene, std::string_view formulation, SimulationOptions options = {});
  ~Simulation();
  /// Moves a simulation; the source can only be destroyed or assigned to.
  Simulation(Simulation&&) noexcept;
  /// Replaces this simulation by another.
  Simulation& operator=(Simulation&&) noexcept;

  /// Integrates from the current time t() to `request.until`, calls the observers, and returns a
  /// summary. The next call continues from there.
  ///
  /// Throws ModelError if `until` is not finite or precedes t(), and std::logic_error if an
  /// observer of this simulation calls it. A numerical failure or a stop request does not throw:
  /// see Result::ending. An exception from an observer leaves run(); then restore a snapshot before
  /// running again.
  Result run(const RunRequest& request = {});

  /// A simulation and its request, for run_together().
  struct LaneJob {
    Simulation* simulation;  ///< not owned
    RunRequest request;      ///< as for run()
    /// The observers need only the steps from the last one before this time (s) on; they get all events
    /// in any case. Asked again after each step that they have seen.
    std::function<double()> next_shown;
    /// Observers of the request that need all steps, but only states, rates and contacts of them.
    std::vector<Observer*> followers = {};
    /// Called at its end with the number of its steps that were made in a lane.
    std::function<void(Result result, long in_lanes)> ended = {};
  };
  /// Runs all simulations that `next` returns, bitwise identical to run(). Fixed time steps of
  /// simulations of one structure for which compilation is requested (SimulationOptions::compile) are made in
  /// lanes: together, wherever no observer sees them (docs/theory/compiled.md). `next` is asked whenever a
  /// lane is empty, and when it had none, again after each end of a run. It may return a simulation whose run
  /// has ended, for another one. An exception of any run leaves all.
  static void run_together(const std::function<std::optional<LaneJob>()>& next);
  /// Greatest number of simulations that run_together() can step together on this machine.
  static int most_together();

  /// The scene as given to the constructor.
  const Scene& scene() const;
  /// Everything that determines a run from the start (values/identity.hpp). Runs of equal identity are
  /// bitwise identical.
  Identity identity() const;
  /// Names and sizes of the simulation's parts: bodies, contacts, instruments, force elements.
  const Layout& layout() const;
  double t() const;  ///< current time, s
  /// Current state: t (s), q (m, rad), v (m/s, rad/s), z.
  State state() const;
  /// Energies and accumulated work since the start, J.
  EnergyLedger ledger() const;
  /// The complete state of the simulation: after restore(snapshot()) a run continues bit for bit as
  /// if uninterrupted. An observer may call it within begin(), step() and end(). Within event() and
  /// sample() the current step is still being passed to the observers, so a snapshot would repeat
  /// that step or miss its samples.
  Snapshot snapshot() const;
  /// Replaces the state by that of a snapshot. Throws SnapshotError if the snapshot is damaged or
  /// belongs to another scene, formulation or program, and std::logic_error if an observer of this
  /// simulation calls it. The simulation is unchanged if it throws.
  void restore(const Snapshot& snapshot);

 private:
  struct Implementation;
  class LaneJobs;
  std::unique_ptr<Implementation> it_;
};

}  // namespace freeplay
