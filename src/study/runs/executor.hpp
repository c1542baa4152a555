// Execution of the runs of a study: by all threads, of which each makes several runs together where their
// mechanisms and schemes allow it (Simulation::run_together). Sweeps, calibrations, attractors and ensembles
// make all their runs here. Each result is available as soon as its run ends, and is bitwise
// identical to that of a run alone.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "compile/compiled_structures.hpp"
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
  /// As Simulation::LaneJob.
  virtual double next_shown() const = 0;
  /// As Simulation::LaneJob.
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

/// The next run of a study, or null if there is none now. A run that ends may be followed by another one.
using NextRun = std::function<std::unique_ptr<StudyRun>()>;
/// Gets a run at its end.
using RunEnded = std::function<void(StudyRun&)>;

/// Makes one run in this thread.
void run_alone(StudyRun& run);

/// Makes all runs that `next` returns on `threads` threads (0: all cores), which call both functions. `runs`:
/// number of runs that are expected. No run is begun after a stop request, which may also interrupt `next`.
/// After an error no run is begun either, and the error is thrown when the others have ended.
void execute(int threads, std::size_t runs, const StopToken& stop, const NextRun& next, const RunEnded& done);

/// Gets the number of runs or jobs that are done, of all, from one thread at a time; may be empty.
using OnProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Calls job(0) … job(jobs − 1) on `threads` threads (0: all cores) until a stop request, which may also
/// interrupt a job. Reports the progress after each job.
void execute_jobs(int threads, std::size_t jobs, const StopToken& stop,
                  const std::function<void(std::size_t)>& job, const OnProgress& on_progress = {});

}  // namespace freeplay
