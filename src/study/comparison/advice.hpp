// Advice: the least expensive numerical setting that keeps a requested error for a scene (`freeplay
// advise`).
//
// Two fine runs determine the horizon up to which single contact onsets are reproducible. It ends
// where they differ by more than a hundredth of the requested error. Up to the horizon each contact
// onset of a setting is compared,
//
//     error: the greatest of |Δt|/interval since the onset before, |Δv|/|v| and |ΔP|/|P| over all,
//
// and must be at most half of the requested error. Onsets slower than a hundredth of their
// contact's fastest so far are excluded, because an accumulation of impacts contains infinitely
// many. Beyond the horizon a setting is assessed by statistics over the whole run from slightly
// perturbed starts: the flight share, the impacts per turn and the dissipated power must not differ
// from those of a fine setting by more than the requested error plus 3.6 standard errors of the
// difference. The bound of the error of statistics is their difference plus twice its
// standard error, even if the requested error is smaller.
#pragma once

#include <string>
#include <vector>

#include "study/comparison/settings.hpp"

namespace freeplay {

/// One statistic over the perturbed starts; values relative to the mean of the reference.
struct Statistic {
  std::string name;
  double reference = 0;   ///< mean of the fine setting
  double difference = 0;  ///< of the setting's mean, relative
  double error = 0;       ///< standard error of the difference, relative (Welch)
  double scatter = 0;     ///< standard deviation of a single run, relative
  double promised() const { return std::abs(difference) + 2 * error; }
};

/// Result of advise().
struct Advice {
  std::vector<Measured> tried;  ///< in the order of their cost
  int chosen = -1;              ///< index into `tried`; −1: none keeps the error
  Reference reference;
  /// Compared by contact onsets; else by the state at Reference::state_time.
  bool by_events = false;
  /// The horizon is the end of the run, so no statistics are needed.
  bool to_the_end = false;
  std::vector<Statistic> statistics;  ///< of the chosen setting beyond the horizon; may be empty
  struct Refused {
    Setting setting;
    Statistic statistic;
  };
  /// Settings with correct contact onsets, but with this statistic outside its bound.
  std::vector<Refused> refused;
  /// Greatest bound of the relative errors of statistics; infinite without statistics.
  double promised() const;
  double seconds = 0;  ///< s, wall time
};

/// Parameters of advise().
struct AdviceRules {
  int starts = 8;             ///< number of starts for statistics
  double play = 0.01;         ///< perturbation of the starts, share of the clearance
  int most_refused = 3;       ///< limit of settings refused by their statistics
  long most_events = 100000;  ///< of a run; with more events contact onsets are not compared
  /// Limit of the right-hand sides of the fine runs over all starts. Longer runs use fewer starts,
  /// but at least four.
  long most_rhs = 20'000'000;
};

/// Tries the settings of one formulation on a scene. A setting is stopped at its first wrong or
/// missing contact onset, and when it has taken more steps than the cost of another setting that
/// keeps the error. Throws AlikeStarts if statistics are needed but starts cannot differ: equal
/// runs have no sampling error.
Advice advise(const Scene& scene, Family family, double error, const Conduct& conduct,
              const std::function<void(double)>& on_progress, const AdviceRules& rules = {});

}  // namespace freeplay
