#include "study/settings/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <set>

#include "study/runs/run_together.hpp"

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
      if (seen.insert(key).second) runs.push_back({key, std::move(one)});
    } else if (study.starts_given) {
      throw error_at(
          study, {"starts"},
          fmt::format("all starts of {} are identical: no drive has a prescribed speed and no joint has "
                      "clearance; use starts = 1",
                      one.scene.string()));
    }
  }
  return runs;
}

}  // namespace freeplay
