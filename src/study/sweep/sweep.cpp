// Threads take runs from those that the process has claimed, and collect the results. Claims and
// results are written to the database in batches, each in one transaction; a batch takes about as
// long as `batch_seconds` to compute:
//
//     open → claimed (batch) → computed by a thread → stored (batch)
//
// Long runs form batches of one. A killed process loses the runs that it had claimed but not
// stored.

#include "study/sweep/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_map>
#include <utility>

#include "study/runs/executor.hpp"

namespace freeplay {
namespace {

/// The keys of a case's starts, of the first one only if they do not differ; or the reason why it cannot run.
struct Checked {
  std::vector<std::string> keys;
  std::exception_ptr error = nullptr;
};

/// Checks the cases in threads, at least up to the first one that cannot run. Only first starts are filled.
std::vector<Checked> check(const Study& study, const std::vector<Case>& all, const Conduct& conduct,
                           int threads) {
  std::vector<Checked> checked(all.size());
  std::atomic<std::size_t> failed = all.size();
  const auto starts_of = [&](std::size_t i) {
    int count = 1;
    while (i + count < all.size() && all[i + count].start > 0) ++count;
    return count;
  };
  execute_jobs(threads, all.size(), conduct.stop, [&](std::size_t i) {
    if (all[i].start != 0 || i > failed) return;
    try {
      const auto found = require_runnable(study, all[i], conduct);
      const int starts = found.starts_differ ? starts_of(i) : 1;
      for (int start = 0; start < starts; ++start)
        checked[i].keys.push_back(run_key(found.all_starts, start));
    } catch (...) {
      checked[i].error = std::current_exception();
      for (auto first = failed.load(); i < first && !failed.compare_exchange_weak(first, i);) continue;
    }
  });
  return checked;
}

}  // namespace

std::vector<PlannedRun> plan(const Study& study, const Conduct& conduct, int threads) {
  if (study.continuation && study.axes.empty())
    throw error_at(study, {"continue"},
                   "the study has no axes to sweep; run `freeplay continue`, which cannot be divided "
                   "(docs/how-to/cluster.md)");
  std::vector<PlannedRun> runs;
  std::set<std::string> seen;
  auto all = cases(study);
  auto checked = check(study, all, conduct, threads);
  const Checked* of_start = nullptr;
  for (std::size_t i = 0; i < all.size() && !conduct.stop(); ++i) {
    auto& one = all[i];
    if (one.start == 0) of_start = &checked[i];
    if (of_start->error) std::rethrow_exception(of_start->error);
    const auto start = static_cast<std::size_t>(one.start);
    if (start < of_start->keys.size()) {
      const auto& key = of_start->keys[start];
      if (seen.insert(key).second) runs.push_back({key, std::move(one), i});
    } else if (study.starts.given) {
      throw error_at(
          study, {"starts"},
          fmt::format("all starts of {} are identical: no drive has a prescribed speed and no joint has "
                      "clearance; use starts = 1",
                      one.scene.string()));
    }
  }
  return runs;
}

namespace {

constexpr double batch_seconds = 0.25;  // s, time of a batch
constexpr std::size_t most_in_batch = 256;
constexpr double count_seconds = 2;  // s, between counts of the runs of other processes

/// The part of one process in a study.
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
    done_ = summary_.found;
    summary_.keys = {keys.begin(), keys.end()};
  }

  SweepSummary run(int threads) {
    const auto missing = summary_.total - summary_.found;
    compilation_.runs = missing;
    try {
      while (!conduct_.stop()) {
        execute(
            threads, missing, conduct_.stop, [&] { return next_run(); },
            [&](StudyRun& run) { take(static_cast<Run&>(run)); });
        store_made();
        if (work_->ended()) break;
        // Other processes compute the remaining runs, or have ended before.
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
    } catch (...) {
      store_made();
      throw;
    }
    store_made();
    summary_.interrupted = conduct_.stop();
    summary_.wall_seconds = seconds();
    summary_.lost = work_->lost();
    if (!summary_.interrupted) summary_.elsewhere = summary_.total - summary_.found - summary_.ran;
    return std::move(summary_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  double seconds() const { return std::chrono::duration<double>(Clock::now() - began_).count(); }

  /// A run with its key.
  struct Run final : CaseRun {
    Run(std::string k, const Study& study, const Case& c, const Conduct& conduct,
        SharedCompilation& compilation)
        : CaseRun(study, c, conduct, &compilation), key(std::move(k)), what(c) {}
    std::string key;
    const Case& what;
  };

  std::unique_ptr<StudyRun> next_run() {
    const auto key = next();
    if (!key) return nullptr;
    return std::make_unique<Run>(*key, study_, *cases_.at(*key), conduct_, compilation_);
  }

  void take(Run& run) {
    auto& result = run.made();
    if (result.ending.status == Ending::Status::interrupted) return;
    result.metrics.turns = {};  // not stored
    result.metrics.mean_turn = {};
    keep({run.key, &run.what, std::move(result)}, run.in_lanes);
  }

  /// Number of runs that all threads compute in the time of a batch, from the progress so far.
  int batch() const {
    const double made = static_cast<double>(summary_.ran);
    const double most = made > 0 ? batch_seconds * made / std::max(seconds(), 1e-3) : 1;
    return static_cast<int>(std::clamp(most, 1.0, static_cast<double>(most_in_batch)));
  }

  std::optional<std::string> next() {
    const std::lock_guard lock(mutex_);
    if (claimed_.empty()) {
      const auto more = work_->claim(batch());
      claimed_.assign(more.begin(), more.end());
    }
    if (claimed_.empty()) return std::nullopt;
    auto key = std::move(claimed_.front());
    claimed_.pop_front();
    return key;
  }

  void keep(MadeRun made, long in_lanes) {
    std::vector<MadeRun> due;
    {
      const std::lock_guard lock(mutex_);
      ++summary_.ran;
      summary_.in_lanes += in_lanes;
      ++done_;
      summary_.failed += made.result.ending.status == Ending::Status::failed;
      made_.push_back(std::move(made));
      // Store the first run at once, to show that the sweep progresses.
      if (summary_.ran == 1 || made_.size() >= most_in_batch || seconds() - stored_at_ >= batch_seconds) {
        due.swap(made_);
        stored_at_ = seconds();
      }
    }
    results_.store(due);
    report();
  }

  void store_made() { results_.store(std::exchange(made_, {})); }

  void report() {
    if (!on_progress_) return;
    const std::lock_guard lock(mutex_);
    if (seconds() - counted_at_ >= count_seconds) {
      counted_at_ = seconds();
      done_ = std::max(done_, work_->done_now() + made_.size());
    }
    on_progress_({done_, summary_.total,
                  seconds() / static_cast<double>(done_ - summary_.found) *
                      static_cast<double>(summary_.total - done_)});
  }

  const Study& study_;
  const Conduct& conduct_;
  Results& results_;
  const std::function<void(const SweepProgress&)>& on_progress_;
  std::unordered_map<std::string, const Case*> cases_;
  std::optional<WorkList> work_;
  SweepSummary summary_;
  SharedCompilation compilation_;
  std::mutex mutex_;  // guards the following members and the summary
  std::deque<std::string> claimed_;
  std::vector<MadeRun> made_;              // computed and not stored
  std::size_t done_ = 0;                   // by all processes, as far as known
  double stored_at_ = 0, counted_at_ = 0;  // s
  Clock::time_point began_ = Clock::now();
};

}  // namespace

SweepSummary sweep(const Study& study, const std::vector<PlannedRun>& runs, const Conduct& conduct,
                   Results& results, const FolderLock& lock, int threads,
                   const std::function<void(const SweepProgress&)>& on_progress, WorkList::Earlier earlier) {
  return Sweep(study, runs, conduct, results, lock, earlier, on_progress).run(threads);
}

}  // namespace freeplay
