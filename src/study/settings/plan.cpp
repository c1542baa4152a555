#include "study/settings/plan.hpp"

#include <fmt/format.h>

#include <set>

namespace freeplay {

std::vector<PlannedRun> plan(const Study& study, const Conduct& conduct) {
  if (study.continuation && study.axes.empty())
    throw error_at(study, {"continue"},
                   "the study has no axes to sweep; run `freeplay continue`, which cannot be divided "
                   "(docs/how-to/cluster.md)");
  std::vector<PlannedRun> runs;
  std::set<std::string> seen;
  Identity all_starts;
  bool alike = false;
  for (auto& one : cases(study)) {
    if (conduct.stop()) break;
    if (one.start == 0) {
      all_starts = identity(study, one, conduct);
      require_runnable(study, one, conduct);
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
