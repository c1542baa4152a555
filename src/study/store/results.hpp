// Results: the database of a sweep, a RunStore with a WorkList (study/store/run_store.hpp).
// study/sweep/sweep.hpp stores runs; figures, tables and claims read them by runs() and the
// functions for lists of one run. A Results object owns the open database.
#pragma once

#include <map>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "measure/turns.hpp"
#include "study/runs/case_run.hpp"
#include "study/settings/expression.hpp"
#include "study/settings/study.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

// Tables of a sweep's database. A run has one row in `runs`, with the digest of its identity as
// key. Its lists have several rows, or one row of blobs, in other tables, which refer to the run by
// the integer of its row. Views show them with the digest:
//
//     turns, flights, impacts, measures, costs       one row for each item
//     spectra (run, amplitude)                       blob: of harmonics 1, 2, …
//     traces  (run, angle, acceleration, position)   blobs: angle contains the first and last angle
//                                                    of uniform samples, or all angles
//
// A blob contains single-precision numbers (IEEE 754 binary32), little-endian, without padding.

/// A trace in the form of its blobs.
struct PackedTrace {
  std::vector<float> angle, acceleration, position;  ///< position: empty without a position sensor
};
/// Conversion between a trace and its blobs. unpacked() returns an empty trace for inconsistent
/// blobs.
PackedTrace packed(const std::vector<TracePoint>& trace);
std::vector<TracePoint> unpacked(const PackedTrace& trace);

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
  /// Runs of an earlier version of the study or of another program (study/store/run_store.hpp).
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

// Statistics of the cells of a study over their perturbed starts. For n values with mean x̄ and
// standard deviation s, the 95 % confidence interval of the mean is x̄ ± t_{n−1}(0.975) s/√n
// (Student). Directions are averaged on the circle; positive values and shares use a transformed
// scale if the interval would leave their range.

/// Mean over starts with Student's 95 % confidence interval of the mean, and the range of the
/// values.
struct Interval {
  int count = 0;
  double mean = 0, low = 0, high = 0;  ///< limits of the interval; NaN for fewer than two values
  double least = 0, greatest = 0;
  bool overlaps(const Interval& other) const { return low <= other.high && other.low <= high; }
};
/// The interval of the finite values.
Interval interval(const std::vector<double>& values);
/// The interval of directions in degrees: the mean direction, in [0, 360), with limits and range
/// from the deviations on the circle, unwrapped about it, so that low may be negative and high may
/// exceed 360. NaN for an interval of half the circle or more.
Interval interval_of_directions(const std::vector<double>& degrees);
/// Transforms an interval to the scale of its values: logarithm for x > 0, logit for a share. With
/// Student's half-width h it becomes x e^(±h/x), or likewise for the odds. A mean at an end of its
/// range has that end as its interval.
Interval within_range(Interval s, TurnMetrics::Kind kind);

/// The interval of one cell and metric: on the circle for directions; on the transformed scale
/// where Student's interval would exceed the range of the values.
Interval cell(const std::vector<RunRow>& runs, const std::string& variant, const std::string& formulation,
              const std::vector<double>& values, TurnMetrics::Name metric);

/// Index of the runs by cell, for studies with many thousands of runs. Refers to the runs, which
/// must outlive it.
class Cells {
 public:
  explicit Cells(const std::vector<RunRow>& runs);
  /// Runs of a cell in their original order; empty if there are none.
  const std::vector<const RunRow*>& at(const std::string& variant, const std::string& formulation,
                                       const std::vector<double>& values) const;
  /// The interval of a cell, as cell().
  Interval of(const std::string& variant, const std::string& formulation, const std::vector<double>& values,
              TurnMetrics::Name metric) const;

 private:
  std::map<std::tuple<std::string, std::string, std::vector<double>>, std::vector<const RunRow*>> runs_;
};

}  // namespace freeplay
