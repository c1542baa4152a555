// Perturbed starts of one mechanism, run on all cores: what each run's statistics are, and between which bounds its columns lie
// at each time. Start k of a seed is the k-th of study/runs/perturb.hpp, so a larger ensemble begins with a smaller one, and each run is,
// bit for bit, the run of that start alone, however many threads there are. Of N values x_i that are finite
//
//     standard error of the mean = s/√N,   95 %: mean ± t_{N−1} s/√N (Student),   quantiles linear between sorted values.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "simulation/columns.hpp"
#include "study/runs/perturb.hpp"
#include "study/sweep/intervals.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// The quantiles of a band.
inline constexpr std::array<double, 5> band_levels{0.05, 0.25, 0.5, 0.75, 0.95};

struct EnsemblePlan {
  std::string formulation = "nonsmooth";
  int starts = 100;  ///< at least 2
  std::uint64_t seed = 1;
  Perturbation how{.turn =
                       0};  ///< by default all begin at the scene's own crank angle: a band is of one phase
  int rows = 200;           ///< of the bands, evenly from the discarded time to the end; at least 2
  std::vector<std::string> columns = {};  ///< of trajectory.csv; none: the contacts' gaps, or all positions
  int threads = 0;                        ///< 0: all cores
  StopToken stop = {};
};

/// Values of the starts, in short.
struct Spread {
  Interval of;                                        ///< count, mean, 95 % of the mean, least and greatest
  double error = 0;                                   ///< standard error of the mean; NaN for fewer than two
  std::array<double, band_levels.size()> quantile{};  ///< NaN without values
};
Spread spread(std::vector<double> values);

struct Ensemble {
  std::vector<std::string> statistics;    ///< paths in run.json, those that any run has
  std::vector<std::vector<double>> runs;  ///< of each start, of each statistic; NaN: absent
  std::vector<Spread> spreads;            ///< of each statistic
  std::vector<std::string> columns;
  std::vector<double> t;                     ///< s
  std::vector<Spread> bands;                 ///< of t and columns, columns side by side
  std::vector<std::string> failures;         ///< of each start; empty where it finished
  double wall_seconds = 0, cpu_seconds = 0;  ///< CPU: of the runs, with their starts
  long steps = 0;
  bool interrupted = false;

  std::size_t finished() const;
  const Spread& band(std::size_t row, std::size_t column) const {
    return bands[row * columns.size() + column];
  }
};

/// What one start gave.
struct StartOutcome {
  std::map<std::string, double> numbers = {};  ///< statistics by their path in run.json
  std::vector<double> rows = {};  ///< of the bands' times, columns side by side; NaN behind where it stopped
  std::string failure = {};       ///< empty: it finished
  double cpu_seconds = 0;
  long steps = 0;
  bool interrupted = false;
};

/// Where outcomes are that need not be made: true when it was one of those.
using KnownStarts = std::function<bool(int start, StartOutcome& outcome)>;

/// Every start of a scene by itself, and all together.
class Starts {
 public:
  /// Of a scene that stays as it is. Throws as run_ensemble.
  Starts(const Scene& scene, const EnsemblePlan& plan);
  StartOutcome make(int start) const;
  /// These starts on the plan's threads. Each is looked for first; then `done` is told, also of those that a stop has ended. Both are
  /// given the place in the list, and are called by one thread at a time.
  void make_all(const std::vector<int>& starts,
                const std::function<bool(std::size_t place, StartOutcome& outcome)>& find,
                const std::function<void(std::size_t place, StartOutcome& outcome, bool found)>& done) const;
  /// Of all starts, in their order.
  Ensemble together(const std::vector<StartOutcome>& outcomes) const;
  const EnsemblePlan& plan() const { return plan_; }

 private:
  const Scene& scene_;
  EnsemblePlan plan_;
  std::vector<Column> columns_;
  std::vector<double> times_;  // s, of the bands
  std::vector<double> near_;
};

/// Runs them. Throws SceneError where starts are all alike, a column is none, or what is kept does not fit in two gigabytes.
Ensemble run_ensemble(const Scene& scene, const EnsemblePlan& plan,
                      const std::function<void(double)>& on_progress, const KnownStarts& known = {});

}  // namespace freeplay
