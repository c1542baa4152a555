// Verdicts: the conclusions of compare, validate, advise, calibrate and sweep in words. Each
// function takes the numbers of a result and returns a few sentences that they support. What
// the numbers leave open is called unknown, with the command or key that determines it.
//
// The functions know no file, scene or run: the verbs and study/comparison fill the structures, so
// that every sentence can be tested on given numbers. They keep no state.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace freeplay {

// Two formulations of a scene (compare)

/// Agreement of single contact events.
struct EventAgreement {
  bool contacts = true;     ///< whether the scene has contacts
  std::size_t pairs = 0;    ///< contact events that correspond
  double horizon = 0;       ///< s, time of the last pair
  bool to_the_end = false;  ///< whether all events of both runs are paired
  bool cut = false;         ///< whether the pairing ends because a list of events is truncated
  double time = 0;          ///< s, greatest difference of times
  double speed = 0;         ///< greatest relative difference of approach speeds
  /// Greatest relative difference of impulses without loads; NaN: no pair of impacts.
  double impulse = NAN;
  int merged = 0;            ///< onsets that one run resolves and the other does not
  int loaded = 0;            ///< pairs whose impulse is mainly that of the load
  bool overlapping = false;  ///< whether impacts overlap in the penalty run at the end of the pairing
};

/// |a − b| over the mean of |a| and |b|, the relative difference of compare; 0 if both are 0.
double relative_difference(double a, double b);

/// A statistic of both runs.
struct StatisticPair {
  std::string name;
  double penalty = 0, nonsmooth = 0;
  double error = NAN;         ///< standard error of the difference; NaN: unknown
  double turnover = 0;        ///< J, energy turned over, for energies
  bool few = false;           ///< too few impacts for a statistic
  bool transient = false;     ///< of a motion without revolutions: batches give no standard error
  double difference() const;  ///< |difference|
  double relative() const;    ///< relative_difference() of the two
  /// Whether they differ by more than 3 standard errors and by more than 1 %.
  bool differs() const;
  /// Whether the standard error exceeds half of the mean size: almost any value would agree.
  bool weak() const;
  /// Whether both are below a thousandth of the energy turned over.
  bool negligible() const;
};

/// A warning of a run.
struct Doubt {
  std::string formulation, reason;
  bool too_deep = false;  ///< it states that contacts penetrate beyond the limit of the formulation
};

/// Cost of a run, and the relative error of its contact events; NaN: unknown.
struct CostAndError {
  double cpu = 0;  ///< s
  double error = NAN;
};

/// Values for the verdict of compare.
struct ComparisonValues {
  std::string scene;    ///< file, for the commands
  std::string stopped;  ///< which runs stopped early, with their times; empty: none
  EventAgreement events;
  std::vector<StatisticPair> statistics;
  /// Fastest approach and greatest impulse of each contact: single values without standard error.
  std::vector<StatisticPair> approaches, impulses;
  /// Contacts with impacts in one run only, whose onsets in the other begin sustained contact.
  std::vector<std::string> one_sided = {};
  /// Revolutions after which statistics have standard errors; 0: longer runs give none.
  double revolutions_needed = 0;
  CostAndError penalty, nonsmooth;
  std::vector<Doubt> doubts = {};
  /// m, rad: greatest difference of the final positions and angles; NaN: not compared.
  double final_length = NAN, final_angle = NAN;
};
std::string verdict(const ComparisonValues& v);

// Measurements (validate)

/// One formulation against a measured signal.
struct SignalAgreement {
  std::string formulation;
  enum class Outcome { agrees, differs, undecided, stopped } outcome = Outcome::undecided;
  std::vector<std::string> findings;     ///< significant differences
  bool faulty_signal = false;            ///< the first concern the measured signal, not the model
  double difference = NAN, limit = NAN;  ///< m/s², of the mean revolutions; explained by the errors
  double signal = NAN;                   ///< m/s², rms of the measured mean revolution
  std::string power;                     ///< which wrong clearances the same test finds
  /// m/s², of the measured signal: beyond its uncertainty, too small to be judged; 0: none.
  double offset = 0;
};
std::string verdict(const std::vector<SignalAgreement>& models);

/// One variant and formulation against measured points.
struct PointsAgreement {
  std::string name;
  SignalAgreement::Outcome outcome = SignalAgreement::Outcome::undecided;
  /// Root mean square of the errors relative to the measured values, over all quantities.
  double relative_error = NAN;
};
std::string verdict(const std::vector<PointsAgreement>& models);

/// Published findings.
struct FindingCount {
  int assessed = 0, holding = 0;
  std::vector<std::string> failing;  ///< variant, formulation and number of each
};
std::string verdict(const FindingCount& count);

// Settings (advise)

/// The setting that advise chose for one formulation.
struct ChosenSetting {
  std::string formulation;
  std::string label;      ///< empty: no setting keeps the error
  double cpu = 0;         ///< s, up to `until`
  double until = 0;       ///< s, end of the time in which single events, or the state, are compared
  bool whole = false;     ///< whether that is the whole run
  double later = NAN;     ///< error bound of statistics of the whole run; NaN: unknown
  double duration = NAN;  ///< s, of the run
};
/// `error`: requested relative error.
std::string verdict(const std::vector<ChosenSetting>& settings, double error, const std::string& scene);

// Calibration (calibrate)

/// A fitted unknown.
struct FittedUnknown {
  std::string name, unit;
  double value = 0, low = NAN, high = NAN;
  bool open = false;  ///< an end of its range is not excluded
};
/// Values for the verdict of calibrate.
struct CalibrationValues {
  bool rejected = false;                  ///< the targets contradict each other or the model
  std::vector<std::string> contradicted;  ///< targets that runs at the optimum do not meet
  bool settled = true;                    ///< the response surfaces predict runs (Fit::settled)
  std::vector<FittedUnknown> unknowns;
  std::string
      ridge;  ///< what the targets determine of several unknowns together, a sentence; empty: each alone
  /// Targets left out of a fit that holds: inside their predicted interval, all.
  int predicted = 0, predictions = 0;
  std::vector<std::string> unpredicted;  ///< targets without which the fit does not hold
};
std::string verdict(const CalibrationValues& v);

// Studies (sweep)

/// A statistic in one cell of a study.
struct CellValue {
  std::string place;  ///< values of the axes in words; empty: a study without axes
  std::string formulation;
  double mean = NAN, low = NAN, high = NAN;  ///< 95 % interval of the mean; NaN: one start
};
/// Values for the verdict of sweep.
struct SweepValues {
  std::size_t runs = 0, failed = 0;
  std::string statistic, unit;
  std::vector<CellValue> cells;
};
std::string verdict(const SweepValues& v);

}  // namespace freeplay
