#include "verification/random_scenes/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "values/result.hpp"
#include "values/warning.hpp"

namespace freeplay::verification::random_scenes {

const char* name_of(Outcome outcome, Suite suite) {
  constexpr const char* names[][outcomes] = {
      {"right", "degraded", "", "refused", "HUNG", "WRONG", "CRASHED"},
      {"right", "warned", "", "refused", "HUNG", "SILENT", "CRASHED"},
      {"right", "doubted", "falsely doubted", "refused", "slow", "SILENT", "CRASHED"},
      {"right", "warned", "", "refused", "HUNG", "SILENT", "CRASHED"}};
  return names[static_cast<int>(suite)][static_cast<int>(outcome)];
}

std::string field(std::string detail) {
  std::ranges::replace(detail, ',', ';');
  return detail.empty() ? "-" : detail;
}

Verdict beyond_bound(const Result& run, const std::string& what, std::string_view noted) {
  const bool failed = run.ending.status == Ending::Status::failed;
  for (const auto& note : run.notes)
    if (is_warning(note) || (!noted.empty() && note.find(noted) != note.npos))
      return failed ? Verdict{Outcome::refused, run.ending.reason + "; run says: " + note}
                    : Verdict{Outcome::doubted, what + "; run says: " + note};
  return {Outcome::silent, failed ? what + "; then stopped: " + run.ending.reason : what};
}

Verdict within(const Result& run, double error, double bound, const std::string& what) {
  if (!(error <= bound))
    return beyond_bound(run, fmt::format("{}: {:.2g}, above {:.2g}", what, error, bound));
  if (run.ending.status == Ending::Status::failed) return {Outcome::refused, run.ending.reason};
  return {Outcome::right, fmt::format("{}: {:.2g}", what, error)};
}

}  // namespace freeplay::verification::random_scenes
