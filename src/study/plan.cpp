#include "study/plan.hpp"

#include <set>

namespace freeplay {

std::vector<PlannedRun> plan(const Study& study, const Conduct& conduct) {
  std::vector<PlannedRun> runs;
  std::set<std::string> seen;
  Identity all_starts;
  for (auto& one : cases(study)) {
    if (conduct.stop()) break;
    if (one.start == 0) {
      all_starts = identity(study, one, conduct);
      require_runnable(study, one, conduct);
    }
    auto key = run_key(all_starts, one.start);
    if (seen.insert(key).second) runs.push_back({std::move(key), std::move(one)});
  }
  return runs;
}

}  // namespace freeplay
