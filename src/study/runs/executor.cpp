#include "study/runs/executor.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

#include "compile/compile.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// Fixed steps of all runs together above which lanes are worth their compilations.
constexpr double lanes_after = 1e6;

/// The threads of a study. If they are more than the cores of the machine, oneTBB's limit is raised: it would
/// otherwise reduce them to the cores and print a warning.
class Threads {
 public:
  /// `wanted`: their number; 0: all cores.
  explicit Threads(int wanted) : arena_(wanted > 0 ? wanted : oneapi::tbb::task_arena::automatic) {
    using Control = oneapi::tbb::global_control;
    const auto limit = Control::active_value(Control::max_allowed_parallelism);
    if (wanted > 0 && static_cast<std::size_t>(wanted) > limit)
      more_.emplace(Control::max_allowed_parallelism, static_cast<std::size_t>(wanted));
  }
  int count() { return arena_.max_concurrency(); }
  void execute(const auto& work) { arena_.execute(work); }

 private:
  std::optional<oneapi::tbb::global_control> more_;
  oneapi::tbb::task_arena arena_;  // takes its threads at its first use
};

/// Calls work(i), 0 <= i < count, on all threads of the arena.
void on_threads(Threads& arena, std::size_t count, const std::function<void(std::size_t)>& work) {
  arena.execute([&] {
    oneapi::tbb::parallel_for(
        oneapi::tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const auto& range) {
          for (auto i = range.begin(); i < range.end(); ++i) try {
              work(i);
            } catch (const Interrupted&) {  // during an assembly or a compilation
            }
        },
        oneapi::tbb::simple_partitioner());
  });
}

/// Makes all runs that `next` returns until it returns null, at most `most` of them at a time, in this
/// thread.
void run_all(int most, const NextRun& next, const RunEnded& done) {
  if (most < 2) {
    while (const auto run = next()) {
      run_alone(*run);
      done(*run);
    }
    return;
  }
  std::deque<std::shared_ptr<StudyRun>> going_on;  // to their next requests
  int begun = 0;
  Simulation::run_together([&]() -> std::optional<Simulation::LaneJob> {
    std::shared_ptr<StudyRun> run;
    if (!going_on.empty()) {
      run = std::move(going_on.front());
      going_on.pop_front();
    } else {
      if (begun == most || !(run = next())) return {};
      ++begun;
    }
    auto* r = run.get();
    return Simulation::LaneJob{.simulation = &r->simulation(),
                               .request = r->request(),
                               .next_shown = [r] { return r->next_shown(); },
                               .followers = r->followers(),
                               .ended =
                                   [&, run](Result result, long in_lanes) {
                                     run->in_lanes += in_lanes;
                                     if (run->take(std::move(result))) {
                                       going_on.push_back(run);
                                     } else {
                                       --begun;
                                       done(*run);
                                     }
                                   }};
  });
}

}  // namespace

SimulationOptions SharedCompilation::options(const Scene& scene, std::string_view formulation) {
  SimulationOptions options{.structures = &structures};
  const auto& o = scene.nonsmooth;
  if (formulation == "nonsmooth" && o.step && o.scheme_in_force() == Scheme::moreau_jean &&
      compile_choice(Compile::automatic) == Compile::automatic &&
      (duration > 0 ? duration : scene.run.duration) / *o.step * static_cast<double>(runs) >= lanes_after)
    options.compile = Compile::always;
  return options;
}

void run_alone(StudyRun& run) {
  while (run.take(run.simulation().run(run.request()))) continue;
}

void execute(int threads, std::size_t runs, const StopToken& stop, const NextRun& next,
             const RunEnded& done) {
  Threads arena(threads);
  const auto workers = static_cast<std::size_t>(std::max(arena.count(), 1));
  // So many that no thread waits, and at most one for each lane.
  const auto most = static_cast<int>(std::clamp<std::size_t>(
      (runs + workers - 1) / workers, 1, static_cast<std::size_t>(Simulation::most_together())));
  std::atomic<bool> failed{false};
  on_threads(arena, workers, [&](std::size_t) {
    std::exception_ptr error;
    const auto next_run = [&]() -> std::unique_ptr<StudyRun> {
      if (failed || stop()) return nullptr;
      try {
        return next();
      } catch (...) {  // the current runs end
        error = std::current_exception();
        failed = true;
        return nullptr;
      }
    };
    try {
      run_all(most, next_run, done);
    } catch (const Interrupted&) {
      throw;
    } catch (...) {
      failed = true;
      throw;
    }
    if (error) std::rethrow_exception(error);
  });
}

void execute_jobs(int threads, std::size_t jobs, const StopToken& stop,
                  const std::function<void(std::size_t)>& job, const OnProgress& on_progress) {
  Threads arena(threads);
  std::mutex mutex;
  std::size_t done = 0;
  on_threads(arena, jobs, [&](std::size_t i) {
    if (stop()) return;
    job(i);
    const std::lock_guard lock(mutex);
    ++done;
    if (on_progress) on_progress(done, jobs);
  });
}

}  // namespace freeplay
