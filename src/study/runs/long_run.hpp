// What chaotic motion amounts to: statistics over perturbed starts, and whether two of them differ by more
// than their own sampling error.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "study/settings/settings.hpp"

namespace freeplay {

/// How long-run statistics are taken. Without a drive of prescribed speed each run is as long as the scene.
struct Sampling {
  int starts = 0;  ///< none below 2
  double revolutions = 1;
  std::uint64_t seed = 1;
  Perturbation how;
};

/// One value per start.
struct LongRun {
  std::vector<double> lost;     ///< W, energy lost in contacts over the time
  std::vector<double> flight;   ///< share of the time without contact, mean over the contacts
  std::vector<double> impacts;  ///< per revolution (per second where nothing turns), mean over the contacts
  std::string stopped;          ///< reason of the first run that did not finish
};

/// The scene at `sampling.starts` starts from number `first`. Empty where they are all alike, and where the ideal mechanism
/// has none.
std::vector<Scene> perturbed_starts(const Scene& scene, const Sampling& sampling, int first,
                                    const Conduct& conduct);

/// Runs every start with every setting, on all cores.
std::vector<LongRun> long_runs(const std::vector<Scene>& starts, const std::vector<Setting>& settings,
                               const Conduct& conduct, const std::function<void(double)>& on_progress);

/// The greater of |difference of the means|/√(s₁²/n₁ + s₂²/n₂) of both statistics (Welch, Biometrika 34
/// (1947) 28); NaN without samples.
double deviation(const LongRun& a, const LongRun& b);

struct Moments {
  double mean = 0, variance = 0;  ///< of a sample
};
Moments moments(const std::vector<double>& x);

/// Sample standard deviation over the mean.
double relative_spread(const std::vector<double>& sample);

}  // namespace freeplay
