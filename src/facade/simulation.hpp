// A scene that moves, for those who need not know what a scene is made of.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "simulation/observer.hpp"
#include "values/identity.hpp"
#include "values/ledger.hpp"
#include "values/result.hpp"
#include "values/snapshot.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

struct SimulationOptions {
  /// An impact law takes the restitution that the scene's penalty law delivers (nonsmooth only).
  bool matched = false;
  /// Where to start from in place of what the scene's run.start asks for; must satisfy the constraints.
  /// Without z, first-order states begin at 0.
  std::optional<State> start = {};
  /// Asked to while the start is assembled: the constructor throws Interrupted. A run has its own (RunRequest::stop).
  StopToken stop = {};
};

struct RunRequest {
  /// s; default the scene's duration. A run goes on from where the last one ended.
  std::optional<double> until = {};
  /// Who watches; in this order, each step after the instruments' samples that lie in it.
  std::vector<Observer*> observers = {};
  bool keep_events = true;              ///< in Result::events
  std::size_t most_events = 1'000'000;  ///< of them; Result::events_cut() tells when there were more
  StopToken stop = {};
};

/// A scene that moves. Owns all that it needs; several live side by side, each in one thread at a time.
class Simulation {
 public:
  /// `formulation`: "penalty" or "nonsmooth". Throws ModelError for what cannot be assembled or made.
  Simulation(Scene scene, std::string_view formulation, SimulationOptions options = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  Result run(const RunRequest& request = {});

  const Scene& scene() const;
  /// All that the digits of a run from the start depend on.
  Identity identity() const;
  const Layout& layout() const;
  double t() const;  ///< s
  State state() const;
  EnergyLedger ledger() const;
  /// Complete: restore(snapshot()) goes on as if nothing had been, bit for bit. Also from within an
  /// observer's begin, step and end; event and sample are called while their step is still being shown.
  Snapshot snapshot() const;
  /// Throws SnapshotError when it is of another scene, formulation or program, and leaves the simulation as it was.
  void restore(const Snapshot& snapshot);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> it_;
};

}  // namespace freeplay
