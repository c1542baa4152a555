#include <fmt/format.h>

#include <stdexcept>

#include "facade/run_folder.hpp"
#include "io/files/run_json.hpp"
#include "mechanism/error.hpp"
#include "verification/extremes/extremes.hpp"
#include "verification/support/apart.hpp"
#include "verification/support/support.hpp"

namespace freeplay::verification {

const char* name_of(Outcome outcome) {
  constexpr const char* names[] = {"right", "degraded", "refused", "WRONG", "HUNG", "CRASHED"};
  return names[static_cast<int>(outcome)];
}

Judged beyond_bound(const Result& run, const std::string& what) {
  const bool failed = run.ending.status != Ending::Status::finished;
  for (const auto& note : run.notes)
    if (note.starts_with("DOUBTFUL"))
      return failed ? Judged{Outcome::refused, run.ending.reason + "; said: " + note}
                    : Judged{Outcome::degraded, what + "; said: " + note};
  return {Outcome::wrong, failed ? what + "; then stopped: " + run.ending.reason : what};
}

Judged within(const Result& run, double error, double bound, const std::string& what) {
  if (!(error <= bound))
    return beyond_bound(run, fmt::format("{}: {:.2g}, above {:.2g}", what, error, bound));
  if (run.ending.status != Ending::Status::finished) return {Outcome::refused, run.ending.reason};
  return {Outcome::right, fmt::format("{}: {:.2g}", what, error)};
}

Judged judge_apart(const Cell& cell, double seconds) {
  const auto work = [&cell] {
    Judged j;
    try {
      j = cell.judge();
    } catch (const SceneError& e) {
      j = {Outcome::refused, e.what()};
      const std::string here = test::source_folder().string() + "/";  // a page is of no machine
      if (j.detail.starts_with(here)) j.detail.erase(0, here.size());
    } catch (const std::exception& e) {
      j = {Outcome::crashed, e.what()};
    }
    return static_cast<char>('0' + static_cast<int>(j.outcome)) + j.detail;
  };
  const auto apart = run_apart(work, seconds);
  if (apart.late) return {Outcome::hung, "no end within its time"};
  if (apart.signal != 0 || apart.said.empty())
    return {Outcome::crashed, "signal " + std::to_string(apart.signal)};
  return {static_cast<Outcome>(apart.said[0] - '0'), apart.said.substr(1)};
}

}  // namespace freeplay::verification
