// Advice: the cheapest setting that keeps an error over all that a user runs.
//
// Two fine runs say how far single touches mean something: to the horizon, where they part by more than a hundredth of
// the error. Up to there each touch of a setting is judged,
//
//     error: the greatest of |Δt|/interval since the touch before, |Δv|/|v| and |ΔP|/|P| over all of them,
//
// and half the error asked for is kept in hand. Touches slower than a hundredth of their contact's fastest before are
// not judged: an accumulation has infinitely many of them. Beyond, a setting is judged by statistics over the whole run from
// slightly moved starts: flight share, impacts per turn and power lost must not differ from those of a fine setting by
// more than the error and 3.6 standard errors of their difference. What can be promised of them is their
// difference with twice its standard error, however small the error asked for is.
#pragma once

#include <string>
#include <vector>

#include "study/runs/long_run.hpp"

namespace freeplay {

/// One statistic over the moved starts: means and their standard errors, relative to the reference's mean.
struct Statistic {
  std::string name;
  double reference = 0;   ///< mean of the fine setting
  double difference = 0;  ///< of the setting's mean, relative
  double error = 0;       ///< standard error of the difference, relative (Welch)
  double scatter = 0;     ///< standard deviation of a single run, relative
  double promised() const { return std::abs(difference) + 2 * error; }
};

struct Advice {
  std::vector<Measured> tried;  ///< in the order of their cost
  int chosen = -1;              ///< into tried; −1: none meets the error
  Reference reference;
  bool by_events = false;   ///< judged by touches; else by the state at Reference::state_time
  bool to_the_end = false;  ///< the horizon is the end of the run: nothing is left to statistics
  std::vector<Statistic>
      statistics;  ///< of the chosen setting, beyond the horizon; empty where none can be taken
  struct Refused {
    Setting setting;
    Statistic statistic;
  };
  std::vector<Refused> refused;  ///< settings that keep every touch, but not this statistic beyond
  /// Greatest relative error of statistics that can be promised; infinite without any.
  double promised() const;
  double seconds = 0;  ///< wall time
};

struct AdviceRules {
  int starts = 8;             ///< of statistics
  double play = 0.01;         ///< share of the play that starts are moved by
  int most_refused = 3;       ///< settings whose statistics may be refused before none is left
  long most_events = 100000;  ///< of a run: beyond them touches are not judged
  /// Right-hand sides of the fine runs at all starts together: longer runs have fewer starts, but four at least.
  long most_rhs = 20'000'000;
};

/// Tries settings of one formulation on the scene. Cheap by design: a setting is stopped at its first touch that is off
/// or missing, and when it has taken more steps than one that keeps the error has cost. Throws AlikeStarts where the horizon
/// comes before the end and starts cannot differ: eight equal runs have no sampling error, and say nothing.
Advice advise(const Scene& scene, Family family, double error, const Conduct& conduct,
              const std::function<void(double)>& on_progress, const AdviceRules& rules = {});

}  // namespace freeplay
