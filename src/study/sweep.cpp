#include "study/sweep.hpp"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_map>

namespace freeplay {
namespace {

/// One process' part in a study.
class Sweep {
 public:
  Sweep(const Study& study, const std::vector<PlannedRun>& runs, const Conduct& conduct, Results& results,
        const FolderLock& lock, WorkList::Earlier earlier,
        const std::function<void(const SweepProgress&)>& on_progress)
      : study_(study), conduct_(conduct), results_(results), on_progress_(on_progress) {
    std::vector<std::string> keys;
    for (const auto& run : runs) {
      keys.push_back(run.key);
      cases_[run.key] = &run.what;
    }
    work_.emplace(results.database(), lock, keys, earlier);
    summary_.total = runs.size();
    summary_.found = work_->found();
    summary_.kept = work_->kept();
    summary_.keys = {keys.begin(), keys.end()};
  }

  SweepSummary run(int threads) {
    oneapi::tbb::task_arena arena(threads > 0 ? threads : oneapi::tbb::task_arena::automatic);
    const int workers = arena.max_concurrency();
    while (!stopped()) {
      arena.execute([&] {
        oneapi::tbb::parallel_for(
            oneapi::tbb::blocked_range<int>(0, workers, 1), [&](const auto&) { work(); },
            oneapi::tbb::simple_partitioner());
      });
      if (work_->ended()) break;
      // Others make what is left, or are gone before they have.
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    summary_.interrupted = conduct_.stop();
    summary_.wall_seconds = seconds();
    if (!summary_.interrupted) summary_.elsewhere = summary_.total - summary_.found - summary_.ran;
    return std::move(summary_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  bool stopped() const { return conduct_.stop() || failed_; }
  double seconds() const { return std::chrono::duration<double>(Clock::now() - began_).count(); }

  /// One thread's part: a run after the other while there are any.
  void work() {
    try {
      while (!stopped()) {
        const auto key = claim();
        if (!key) return;
        const auto& one = *cases_.at(*key);
        const auto result = run_case(study_, one, conduct_);
        if (result.ending.status == Ending::Status::interrupted) return;
        store(*key, one, result);
      }
    } catch (const Interrupted&) {  // while a start was made: its run is none
    } catch (...) {
      failed_ = true;  // the others end the runs that they are at
      throw;
    }
  }

  std::optional<std::string> claim() {
    const std::lock_guard lock(mutex_);
    return work_->claim();
  }

  void store(const std::string& key, const Case& one, const CaseResult& result) {
    const std::lock_guard lock(mutex_);
    results_.store(key, one, result);
    ++summary_.ran;
    summary_.failed += result.ending.status == Ending::Status::failed;
    if (!on_progress_) return;
    const auto done = work_->done_now();
    on_progress_({done, summary_.total,
                  seconds() / static_cast<double>(done - summary_.found) *
                      static_cast<double>(summary_.total - done)});
  }

  const Study& study_;
  const Conduct& conduct_;
  Results& results_;
  const std::function<void(const SweepProgress&)>& on_progress_;
  std::unordered_map<std::string, const Case*> cases_;
  std::optional<WorkList> work_;
  SweepSummary summary_;
  std::mutex mutex_;
  std::atomic<bool> failed_{false};
  Clock::time_point began_ = Clock::now();
};

}  // namespace

SweepSummary sweep(const Study& study, const std::vector<PlannedRun>& runs, const Conduct& conduct,
                   Results& results, const FolderLock& lock, int threads,
                   const std::function<void(const SweepProgress&)>& on_progress, WorkList::Earlier earlier) {
  return Sweep(study, runs, conduct, results, lock, earlier, on_progress).run(threads);
}

}  // namespace freeplay
