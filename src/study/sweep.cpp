#include "study/sweep.hpp"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <mutex>

namespace freeplay {
SweepSummary sweep(const Study& study, const Conduct& conduct, Results& results, int threads,
                   const std::function<void(const SweepProgress&)>& on_progress, bool keep_others) {
  using Clock = std::chrono::steady_clock;
  const auto began = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - began).count(); };
  const auto all = cases(study);
  std::set<std::string> keep;
  std::vector<std::pair<std::string, const Case*>> missing;
  const auto present = results.keys();
  Identity all_starts;  // a bad scene or study shows here, before anything runs
  for (const auto& one : all) {
    if (one.start == 0) all_starts = identity(study, one, conduct);
    const auto key = run_key(all_starts, one.start);
    if (keep.insert(key).second && !present.contains(key)) missing.emplace_back(key, &one);
  }
  SweepSummary summary;
  summary.dropped = keep_others ? 0 : present.size() - (keep.size() - missing.size());
  if (!keep_others) results.retain(keep);

  summary.total = keep.size();
  summary.found = keep.size() - missing.size();
  summary.keys = std::move(keep);
  std::mutex mutex;
  oneapi::tbb::task_arena arena(threads > 0 ? threads : oneapi::tbb::task_arena::automatic);
  arena.execute([&] {
    oneapi::tbb::parallel_for(
        oneapi::tbb::blocked_range<std::size_t>(0, missing.size(), 1),
        [&](const auto& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) {
            if (conduct.stop()) return;
            const auto& [key, one] = missing[i];
            const auto result = run_case(study, *one, conduct);
            const std::lock_guard lock(mutex);
            if (result.ending.status == Ending::Status::interrupted) return;
            results.store(key, *one, result);
            ++summary.ran;
            summary.failed += result.ending.status == Ending::Status::failed;
            const auto left = static_cast<double>(missing.size() - summary.ran);
            if (on_progress)
              on_progress({summary.found + summary.ran, summary.total,
                           seconds() / static_cast<double>(summary.ran) * left});
          }
        },
        oneapi::tbb::simple_partitioner());
  });
  summary.interrupted = conduct.stop();
  summary.wall_seconds = seconds();
  return summary;
}

}  // namespace freeplay
