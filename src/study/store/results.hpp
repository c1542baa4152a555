// The results of a sweep: its tables are in study/store/results_tables.hpp, the list of its work in study/store/work_list.hpp.
#pragma once

#include <set>
#include <span>

#include "study/runs/case_run.hpp"
#include "study/settings/expression.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

/// One row of `runs` as figures and claims use it.
struct RunRow {
  std::string key, variant, formulation;
  int start = 0;
  std::vector<double> values;  ///< of the axes
  std::array<double, TurnMetrics::count> metric{};
  std::vector<double> measures;  ///< of the study
  std::string doubt;             ///< what the run says of itself that makes it DOUBTFUL; or ""
};

/// Runs that are there though the study does not name them.
struct KeptRuns {
  std::string variant, formulation;
  std::size_t count = 0;
};

/// What a study derives from a run: each from axes, statistics, measures and what is derived before it; NaN: absent.
class Deriver {
 public:
  explicit Deriver(const Study& study);
  std::vector<double> operator()(const RunRow& row) const;

 private:
  std::vector<Expression> expressions_;
};

/// A run that was made, to be stored.
struct MadeRun {
  std::string key;
  const Case* what;
  CaseResult result;
};

class Results : public RunStore {
 public:
  /// Opens or makes the file; `axes` are the names of its columns. Throws OutputError, also when the file
  /// holds another study's axes, or keys of another kind than run_key().
  Results(const std::filesystem::path& file, const Study& study, StopToken stop = {});

  /// Keys of the runs that are there.
  std::set<std::string> keys() const;
  /// All of them or none.
  void store(std::span<const MadeRun> batch);
  /// Finished runs by variant, formulation, axes and start; of these keys, or with none given all that the study names.
  std::vector<RunRow> runs(const std::set<std::string>& keys = {}) const;
  /// Runs that failed, of those that the study names: variant, formulation, reason.
  std::vector<std::array<std::string, 3>> failures() const;
  /// Runs of an earlier form of the study, or of another program (study/store/work_list.hpp).
  std::vector<KeptRuns> kept() const;
  /// Removes these, and no other.
  void prune();
  std::vector<Flight> flights(const std::string& key) const;
  std::vector<CountedImpact> impacts(const std::string& key) const;
  std::vector<double> spectrum(const std::string& key) const;
  std::vector<TracePoint> trace(const std::string& key) const;
  double cpu_seconds() const;
  /// Computes what the study derives, of every finished run, and shows it in the view `named`. A change of an expression runs
  /// nothing again.
  void derive(const Study& study);

 private:
  std::size_t axes_ = 0;
  std::vector<std::string> measures_;  // names
  std::string shown_;                  // columns of runs
};

}  // namespace freeplay
