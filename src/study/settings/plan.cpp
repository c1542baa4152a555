#include "study/settings/plan.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <set>

#include "study/runs/threads.hpp"

namespace freeplay {

namespace {

/// The error of each first start that cannot run, at least of the first such case; null for the others.
std::vector<std::exception_ptr> errors_of(const Study& study, const std::vector<Case>& all,
                                          const Conduct& conduct, int threads) {
  std::vector<std::exception_ptr> errors(all.size());
  std::atomic<std::size_t> failed = all.size();
  Threads arena(threads);
  arena.execute([&] {
    oneapi::tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
      if (all[i].start != 0 || i > failed || conduct.stop()) return;
      try {
        require_runnable(study, all[i], conduct);
      } catch (...) {
        errors[i] = std::current_exception();
        for (auto first = failed.load(); i < first && !failed.compare_exchange_weak(first, i);) continue;
      }
    });
  });
  return errors;
}

}  // namespace

std::vector<PlannedRun> plan(const Study& study, const Conduct& conduct, int threads) {
  if (study.continuation && study.axes.empty())
    throw error_at(study, {"continue"},
                   "the study has no axes to sweep; run `freeplay continue`, which cannot be divided "
                   "(docs/how-to/cluster.md)");
  std::vector<PlannedRun> runs;
  std::set<std::string> seen;
  Identity all_starts;
  bool alike = false;
  auto all = cases(study);
  const auto errors = errors_of(study, all, conduct, threads);
  for (std::size_t i = 0; i < all.size(); ++i) {
    auto& one = all[i];
    if (conduct.stop()) break;
    if (one.start == 0) {
      all_starts = identity(study, one, conduct);
      if (errors[i]) std::rethrow_exception(errors[i]);
      alike = !has_starts(study, one);
    }
    if (one.start > 0 && alike) {
      if (study.starts_given)
        throw error_at(
            study, {"starts"},
            fmt::format("all starts of {} are identical: no drive has a prescribed speed and no joint has "
                        "clearance; use starts = 1",
                        one.scene.string()));
      continue;
    }
    auto key = run_key(all_starts, one.start);
    if (seen.insert(key).second) runs.push_back({std::move(key), std::move(one)});
  }
  return runs;
}

}  // namespace freeplay
