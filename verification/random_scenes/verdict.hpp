// The outcome of a run in all three suites: the map of extreme parameters, random scenes without a
// reference, and random scenes with a reference for every row.
#pragma once

#include <string>

namespace freeplay {
struct Result;
}  // namespace freeplay

namespace freeplay::verification::random_scenes {

enum class Suite { map, agreement, rows };

/// From good to bad; judgements.csv has their numbers.
enum class Outcome {
  right,    ///< within every bound
  doubted,  ///< outside one, and the run says so; of known rows also: not known to be right, and doubted
  falsely_doubted,  ///< known to be right in all rows, and the run says DOUBTFUL
  refused,          ///< stopped or declined with a reason, and right until then
  hung,             ///< did not end within its time
  silent,           ///< outside a bound, and nothing said
  crashed
};
inline constexpr int outcomes = static_cast<int>(Outcome::crashed) + 1;

/// The word for it in the results of a suite.
const char* name_of(Outcome outcome, Suite suite);
/// Where every row is known a refusal and a false doubt are defects, too.
inline bool is_defect(Outcome o, Suite suite) {
  return o >= (suite == Suite::rows ? Outcome::falsely_doubted : Outcome::hung);
}

struct Verdict {
  Outcome outcome = Outcome::right;
  std::string detail = {};  ///< what was off, the reason of a refusal, or the doubt
  std::string check = {};   ///< that was not met; empty: none
  double known =
      0;  ///< contact onsets that the run was held to, 0 to 3; share of the rows that a reference knows
  double cpu = 0;  ///< s, of the run itself
};

/// What a run that misses a bound by `what` amounts to: doubted if a note begins with DOUBTFUL or holds `noted` (unless that
/// is empty), else silent; a run that also failed is refused or silent.
Verdict beyond_bound(const Result& run, const std::string& what, std::string_view noted = {});

/// Right when `error`, taken where the run ended, is within `bound`; else what the program said decides. A
/// failed run is refused only if it was right until then.
Verdict within(const Result& run, double error, double bound, const std::string& what);

}  // namespace freeplay::verification::random_scenes
