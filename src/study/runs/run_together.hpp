// Runs of a study that one thread makes together, where their mechanisms and schemes allow it
// (Simulation::run_together). Sweeps, calibrations, attractors and ensembles make all their runs here.
// Each result is available as soon as its run ends, and has the digits of a run alone.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "facade/compiled_structures.hpp"
#include "facade/simulation.hpp"

namespace freeplay {

/// One run of a study: a simulation that is run once or several times.
class StudyRun {
 public:
  StudyRun() = default;
  virtual ~StudyRun() = default;
  StudyRun(const StudyRun&) = delete;
  virtual Simulation& simulation() = 0;
  /// What is run next.
  virtual RunRequest request() = 0;
  /// As Simulation::Together.
  virtual double next_shown() const = 0;
  /// As Simulation::Together.
  virtual std::vector<Observer*> followers() const { return {}; }
  /// Takes the result of the last request. Returns whether there is another request.
  virtual bool take(Result result) = 0;

  long in_lanes = 0;  ///< steps made together with other runs
};

/// Compiled functions that the runs of a study share.
struct SharedCompilation {
  std::size_t runs = 1;  ///< their number
  double duration = 0;   ///< s, of each run; 0: that of its scene
  CompiledStructures structures;

  /// Options of a simulation of this study. Its mechanism is compiled at once if all runs together have
  /// so many fixed steps that lanes are worth it.
  SimulationOptions options(const Scene& scene, std::string_view formulation);
};

/// Number of runs that a thread makes at a time, so that no thread waits: the share of each of
/// `threads`, at most one for each lane.
int most_at_a_time(std::size_t runs, int threads);

/// Makes all runs that `next` returns until it returns null, at most `most` of them at a time, in this
/// thread. `done` gets each at its end.
void run_all(int most, const std::function<std::unique_ptr<StudyRun>()>& next,
             const std::function<void(StudyRun&)>& done);

}  // namespace freeplay
