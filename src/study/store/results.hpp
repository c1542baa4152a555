// Results: the database of a sweep. results_tables.hpp defines its tables, work_list.hpp the list
// of its runs. study/sweep/sweep.hpp stores runs; figures, tables and claims read them by runs()
// and the functions for lists of one run. A Results object owns the open database.
#pragma once

#include <set>
#include <span>

#include "study/runs/case_run.hpp"
#include "study/settings/expression.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

/// One row of the table `runs`, as figures and claims use it.
struct RunRow {
  std::string key, variant, formulation;
  int start = 0;
  std::vector<double> values;  ///< of the axes
  std::array<double, TurnMetrics::count> metric{};
  std::vector<double> measures;  ///< of the study
  std::string doubt;             ///< the warnings of the run; or ""
};

/// Runs in the database that the study does not name.
struct KeptRuns {
  std::string variant, formulation;
  std::size_t count = 0;
};

/// Evaluates the derived columns of a study for one run: from axes, statistics, measures and
/// columns derived before. NaN: absent.
class Deriver {
 public:
  explicit Deriver(const Study& study);
  std::vector<double> operator()(const RunRow& row) const;

 private:
  std::vector<Expression> expressions_;
};

/// A completed run to be stored.
struct MadeRun {
  std::string key;
  const Case* what;
  CaseResult result;
};

/// The database of one study's runs.
class Results : public RunStore {
 public:
  /// Opens or creates the file. `axes` are the names of its columns. Throws OutputError, also if
  /// the file has the axes of another study, or keys of another kind than run_key().
  Results(const std::filesystem::path& file, const Study& study, StopToken stop = {});

  /// Keys of all stored runs.
  std::set<std::string> keys() const;
  /// Stores all runs of the batch in one transaction.
  void store(std::span<const MadeRun> batch);
  /// Finished runs, ordered by variant, formulation, axes and start: those with the given keys, or
  /// all that the study names.
  std::vector<RunRow> runs(const std::set<std::string>& keys = {}) const;
  /// Failed runs that the study names: variant, formulation, reason.
  std::vector<std::array<std::string, 3>> failures() const;
  /// Runs of an earlier version of the study or of another program (study/store/work_list.hpp).
  std::vector<KeptRuns> kept() const;
  /// Deletes exactly these runs.
  void prune();
  std::vector<Flight> flights(const std::string& key) const;
  std::vector<CountedImpact> impacts(const std::string& key) const;
  std::vector<double> spectrum(const std::string& key) const;
  std::vector<TracePoint> trace(const std::string& key) const;
  double cpu_seconds() const;
  /// Computes the derived columns of every finished run, and shows them in the view `named`. A
  /// changed expression needs no new runs.
  void derive(const Study& study);

 private:
  std::size_t axes_ = 0;
  std::vector<std::string> measures_;  // their names
};

}  // namespace freeplay
