// Ensemble: runs of one mechanism from perturbed starts on all cores, with statistics over the runs
// and bands of the trajectory's columns over time. Start k of a seed is the k-th of
// study/runs/perturb.hpp, so a larger ensemble contains a smaller one, and each run equals the run
// of that start alone bit for bit, for any number of threads. Of N finite values x_i
//
//     standard error of the mean = s/√N,   95 % interval: mean ± t_{N−1} s/√N (Student),
//     quantiles: linear between sorted values.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "simulation/table_rows.hpp"
#include "study/runs/perturb.hpp"
#include "study/store/results.hpp"
#include "study/store/run_store.hpp"
#include "values/stop.hpp"
#include "values/table.hpp"

namespace freeplay {

struct Scene;

/// Quantiles of a band.
inline constexpr std::array<double, 5> band_levels{0.05, 0.25, 0.5, 0.75, 0.95};

/// Specification of an ensemble.
struct EnsemblePlan {
  std::string formulation = "nonsmooth";
  int starts = 100;  ///< at least 2
  std::uint64_t seed = 1;
  /// Default: all start at the scene's crank angle, so a band is of one phase.
  Perturbation how{.turn = 0};
  int rows = 200;  ///< times of the bands, uniform from the discarded time to the end; at least 2
  /// Of trajectory.csv; empty: gaps of the contacts, or all positions.
  std::vector<std::string> columns = {};
  int threads = 0;  ///< 0: all cores
  StopToken stop = {};
};

/// Statistics of one quantity over the starts.
struct Spread {
  Interval of;       ///< count, mean with its 95 % interval, least and greatest value
  double error = 0;  ///< standard error of the mean; NaN for fewer than two
  std::array<double, band_levels.size()> quantile{};  ///< NaN without values
};
/// Statistics of the finite values.
Spread spread(std::vector<double> values);

/// Result of an ensemble.
struct Ensemble {
  std::vector<std::string> statistics;    ///< paths in run.json that any run has
  std::vector<std::vector<double>> runs;  ///< for each start, for each statistic; NaN: absent
  std::vector<Spread> spreads;            ///< for each statistic
  std::vector<std::string> columns;
  std::vector<double> t;  ///< s
  /// For each time and column, columns in the inner loop.
  std::vector<Spread> bands;
  std::vector<std::string> failures;         ///< for each start its error; empty if it finished
  double wall_seconds = 0, cpu_seconds = 0;  ///< s; CPU: of the runs, including their starts
  long steps = 0;
  long in_lanes = 0;  ///< of these steps, those made together with other starts
  bool interrupted = false;

  std::size_t finished() const;
  const Spread& band(std::size_t row, std::size_t column) const {
    return bands[row * columns.size() + column];
  }
};

/// Result of one start.
struct StartOutcome {
  std::string key = {};                        ///< in the database; empty: it was not looked for
  std::map<std::string, double> numbers = {};  ///< statistics by their paths in run.json
  /// At the times of the bands, columns in the inner loop; NaN after an early end.
  std::vector<double> rows = {};
  std::string failure = {};  ///< empty if it finished
  double cpu_seconds = 0;
  long steps = 0;
  long in_lanes = 0;  ///< steps made together with other starts
  bool interrupted = false;
};

class EnsembleStore;

/// The starts of a scene: each as a run, and all as an ensemble.
class Starts {
 public:
  /// Refers to the scene, which must not change. Throws as run_ensemble().
  Starts(const Scene& scene, const EnsemblePlan& plan);
  /// Runs these starts on the plan's threads, where possible in lanes (docs/theory/compiled.md).
  /// Takes those that `known` has from there; it may be null. Calls `done`, by one thread at a time,
  /// with the index in the list, also for interrupted starts.
  void make_all(const std::vector<int>& starts, const EnsembleStore* known,
                const std::function<void(std::size_t place, StartOutcome& outcome, bool found)>& done) const;
  /// Statistics over all starts, given in their order.
  Ensemble together(const std::vector<StartOutcome>& outcomes) const;
  const EnsemblePlan& plan() const { return plan_; }

 private:
  struct Run;

  const Scene& scene_;
  EnsemblePlan plan_;
  std::vector<Column> columns_;
  std::vector<double> times_;  // s, of the bands
  std::vector<double> near_;
};

/// Runs an ensemble, without the starts that `known` has. Throws SceneError if starts cannot differ, a
/// value cannot be varied, a column does not exist, or the stored values exceed two gigabytes.
Ensemble run_ensemble(const Scene& scene, const EnsemblePlan& plan,
                      const std::function<void(double)>& on_progress, const EnsembleStore* known = nullptr);

/// ensemble.json, without provenance.
nlohmann::json to_json(const EnsemblePlan& plan, const Ensemble& all);
/// statistics.csv, starts.csv and bands.csv. A number that is not finite is an empty field.
Table statistics_table(const Ensemble& all);
Table runs_table(const Ensemble& all);
Table bands_table(const Ensemble& all);

// Database of an ensemble's starts (study/store/run_store.hpp): tables runs (run, start, failure,
// steps, rows: a blob of doubles) and numbers (run, name, value).

/// The database.
class EnsembleStore : public RunStore {
 public:
  explicit EnsembleStore(const std::filesystem::path& file, Database::Access access = Database::Access::write,
                         StopToken stop = {});
  /// Reads the result of a start; false if there is none with its key.
  bool find(StartOutcome& outcome) const;
  void store(int start, const StartOutcome& outcome) const;
};

/// Identity that all starts share, for their keys (run_key()): everything that affects a start, but not
/// the number of starts and threads.
Identity identity(const Scene& scene, const EnsemblePlan& plan);

}  // namespace freeplay
