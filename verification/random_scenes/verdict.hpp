// The outcome of a run in all three suites: the map of extreme parameters, random scenes without a
// reference, and random scenes with a reference for every row.
#pragma once

#include <string>

namespace freeplay {
struct Result;
}  // namespace freeplay

namespace freeplay::verification::random_scenes {

/// `flexible` has the checks of `agreement`, for mechanisms with beams.
enum class Suite { map, agreement, rows, flexible };

/// From best to worst; judgements.csv contains their numbers.
enum class Outcome {
  right,  ///< within every bound
  /// outside one, and the run says so; of known rows also: not known to be right, and doubted
  doubted,
  falsely_doubted,  ///< known to be right in all rows, and the run gives a warning
  refused,          ///< stopped or declined with a reason, and right until then
  hung,             ///< did not end within its time
  silent,           ///< outside a bound, and nothing said
  crashed
};
inline constexpr int outcomes = static_cast<int>(Outcome::crashed) + 1;

/// The word for an outcome in the results of a suite.
const char* name_of(Outcome outcome, Suite suite);
/// Where every row is known, a refusal and a false doubt are defects, too.
inline bool is_defect(Outcome o, Suite suite) {
  return o >= (suite == Suite::rows ? Outcome::falsely_doubted : Outcome::hung);
}

struct Verdict {
  Outcome outcome = Outcome::right;
  std::string detail = {};  ///< the deviation, the reason of a refusal, or the doubtful note
  std::string check = {};   ///< the check that was not met; empty: none
  /// number of compared contact onsets, 0 to 3; share of the rows with a reference
  double known = 0;
  double cpu = 0;  ///< s, of the run itself
};

/// A verdict's detail as a field of CSV.
std::string field(std::string detail);

/// What a run that misses a bound by `what` amounts to: doubted if a note is a warning or contains
/// `noted` (unless that is empty), else silent; a run that also failed is refused or silent.
Verdict beyond_bound(const Result& run, const std::string& what, std::string_view noted = {});

/// Right if `error`, taken at the end of the run, is within `bound`; else the notes of the run
/// decide. A failed run is refused only if it was right until then.
Verdict within(const Result& run, double error, double bound, const std::string& what);

}  // namespace freeplay::verification::random_scenes
