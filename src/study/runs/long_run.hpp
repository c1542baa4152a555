// Statistics of chaotic motion over runs from perturbed starts, and a test whether two settings
// differ by more than the sampling error (Welch's t statistic). `freeplay tradeoff` and `advise`
// use them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "study/settings/settings.hpp"

namespace freeplay {

/// Number and length of the runs. Without a drive of prescribed speed, each run is as long as the
/// scene's.
struct Sampling {
  int starts = 0;  ///< fewer than 2: no statistics
  double revolutions = 1;
  std::uint64_t seed = 1;
  Perturbation how;
};

/// Statistics of one setting, with one value for each start.
struct LongRun {
  std::vector<double> lost;    ///< W, mean power dissipated in contacts
  std::vector<double> flight;  ///< share of the time without contact, mean over contacts
  /// Per revolution (per second without a drive of prescribed speed), mean over contacts.
  std::vector<double> impacts;
  std::string stopped;  ///< reason of the first run that did not finish; else empty
};

/// The scene at `sampling.starts` starts from number `first`. Empty if the starts cannot differ, or
/// if the ideal mechanism has no start.
std::vector<Scene> perturbed_starts(const Scene& scene, const Sampling& sampling, int first,
                                    const Conduct& conduct);

/// Runs all starts with all settings in parallel.
std::vector<LongRun> long_runs(const std::vector<Scene>& starts, const std::vector<Setting>& settings,
                               const Conduct& conduct, const std::function<void(double)>& on_progress);

/// Welch's statistic |difference of the means|/√(s₁²/n₁ + s₂²/n₂), the greater of those of the
/// dissipated power and the flight share (Welch, Biometrika 34 (1947) 28). NaN without samples.
double deviation(const LongRun& a, const LongRun& b);

/// Sample mean and sample variance.
struct Moments {
  double mean = 0, variance = 0;  ///< of the sample
};
/// Mean of n values, and their variance with the divisor n − 1.
Moments moments(const std::vector<double>& x);

/// Sample standard deviation over the mean.
double relative_spread(const std::vector<double>& sample);

}  // namespace freeplay
