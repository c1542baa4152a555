#include "verification/random_scenes/verdict.hpp"

#include <fmt/format.h>

#include "values/result.hpp"

namespace freeplay::verification::random_scenes {

const char* name_of(Outcome outcome, Suite suite) {
  constexpr const char* names[][outcomes] = {
      {"right", "degraded", "", "refused", "HUNG", "WRONG", "CRASHED"},
      {"right", "told", "", "refused", "HUNG", "SILENT", "CRASHED"},
      {"right", "doubted", "falsely doubted", "refused", "slow", "SILENT", "CRASHED"}};
  return names[static_cast<int>(suite)][static_cast<int>(outcome)];
}

Verdict beyond_bound(const Result& run, const std::string& what, std::string_view noted) {
  const bool failed = run.ending.status == Ending::Status::failed;
  for (const auto& note : run.notes)
    if (note.starts_with("DOUBTFUL") || (!noted.empty() && note.find(noted) != note.npos))
      return failed ? Verdict{Outcome::refused, run.ending.reason + "; said: " + note}
                    : Verdict{Outcome::doubted, what + "; said: " + note};
  return {Outcome::silent, failed ? what + "; then stopped: " + run.ending.reason : what};
}

Verdict within(const Result& run, double error, double bound, const std::string& what) {
  if (!(error <= bound))
    return beyond_bound(run, fmt::format("{}: {:.2g}, above {:.2g}", what, error, bound));
  if (run.ending.status == Ending::Status::failed) return {Outcome::refused, run.ending.reason};
  return {Outcome::right, fmt::format("{}: {:.2g}", what, error)};
}

}  // namespace freeplay::verification::random_scenes
