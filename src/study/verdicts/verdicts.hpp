// Verdicts: the conclusions of compare, validate, advise, calibrate and sweep in words. Each
// function takes the numbers of a result and returns one or two sentences that they support. What
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
  double impulse = NAN;     ///< greatest relative difference of impulses; NaN: no pair of impacts
};

/// A statistic of both runs.
struct StatisticPair {
  std::string name;
  double penalty = 0, nonsmooth = 0;
  double error = NAN;  ///< standard error of the difference; NaN: unknown
  /// |difference| over the mean size of the two; 0 if both are 0.
  double relative() const;
  /// Whether they differ by more than 3 standard errors and by more than 1 %.
  bool differs() const;
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
  /// Revolutions after which statistics have standard errors; 0: longer runs give none.
  double revolutions_needed = 0;
  CostAndError penalty, nonsmooth;
};
std::string verdict(const ComparisonValues& v);

// Measurements (validate)

/// One formulation against a measured signal.
struct SignalAgreement {
  std::string formulation;
  enum class Outcome { agrees, differs, undecided, stopped } outcome = Outcome::undecided;
  std::string finding;                      ///< the first significant difference
  double difference = NAN, expected = NAN;  ///< m/s², of the mean revolutions; explained by the errors
  double peak_ratio = NAN;                  ///< median peak, model over measurement
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
  std::string label;   ///< empty: no setting keeps the error
  double cpu = 0;      ///< s, up to `until`
  double until = 0;    ///< s, end of the time in which single events, or the state, are compared
  bool whole = false;  ///< whether that is the whole run
  double later = NAN;  ///< error of statistics of the whole run that can be guaranteed; NaN: unknown
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
  std::vector<FittedUnknown> unknowns;
  int predicted = 0, predictions = 0;  ///< targets left out: inside their predicted interval, all
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
