// Measurer: evaluates the measures of a study (study/settings/study_parts.hpp) during one run, by
// observers. It stores sums, and all values only for quantiles.
//
// Use: construct with the scene and layout, attach observers() to the run, then call finish(). Owns
// its observers; refers to the study.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "measure/turns.hpp"
#include "simulation/observer.hpp"
#include "study/settings/study.hpp"
#include "study/settings/study_parts.hpp"

namespace freeplay {

// Reducer: accumulates the values of one column and computes a measure from them
// (study/settings/study_parts.hpp). The first value x₀ is subtracted before summation, so that small
// deviations from a large mean keep their digits:
//
//     d = x − x₀,   mean = x₀ + ∫d/T,   var = ∫d²/T − (∫d/T)²,   rms² = mean² + var.

/// Accumulates one column for one measure. Refers to the measure.
class Reducer {
 public:
  explicit Reducer(const Measure& measure) : measure_(&measure) {}

  /// Adds a row at t (s). x is linear between rows.
  void row(double t, double x) {
    if (count_ == 0) begin(t, x);
    const double d = x - zero_, h = t - t_;
    weight_ += h;
    area_ += 0.5 * h * (d_ + d);
    squares_ += 0.5 * h * (d_ * d_ + d * d);
    take(t, x);
  }
  /// Adds a mean over the time since the previous row.
  void mean_row(double t, double x) {
    if (count_ == 0) begin(t_, x);
    const double d = x - zero_, h = t - t_;
    weight_ += h;
    area_ += h * d;
    squares_ += h * d * d;
    take(t, x);
  }
  /// Sets the beginning of the first mean.
  void since(double t) { t_ = t; }
  /// Adds a value without time; all have equal weight.
  void point(double t, double x) {
    if (count_ == 0) begin(t, x);
    const double d = x - zero_;
    weight_ += 1;
    area_ += d;
    squares_ += d * d;
    take(t, x);
  }
  /// Adds a value that counts for the extremes only.
  void extreme(double x) {
    low_ = std::min(low_, x);
    high_ = std::max(high_, x);
  }
  bool empty() const { return count_ == 0; }

  /// The measure; NaN without values.
  double value() const {
    if (measure_->reduce == Reduce::count) return static_cast<double>(count_);
    if (count_ == 0) return NAN;
    const double share = weight_ > 0 ? area_ / weight_ : 0, mean = zero_ + share;
    const double variance = weight_ > 0 ? std::max(0.0, squares_ / weight_ - share * share) : 0;
    switch (measure_->reduce) {
      case Reduce::mean:
        return mean;
      case Reduce::rms:
        return std::sqrt(mean * mean + variance);
      case Reduce::std:
        return std::sqrt(variance);
      case Reduce::min:
        return low_;
      case Reduce::max:
        return high_;
      case Reduce::peak:
        return std::max(std::abs(low_), std::abs(high_));
      case Reduce::first:
        return first_;
      case Reduce::last:
        return last_;
      case Reduce::quantile: {
        auto sorted = all_;
        std::ranges::sort(sorted);
        return quantile(sorted, measure_->q);
      }
      case Reduce::count:
        break;
    }
    return NAN;
  }

 private:
  void begin(double t, double x) {
    zero_ = first_ = x;
    t_ = t;
    d_ = 0;
  }
  void take(double t, double x) {
    t_ = t;
    d_ = x - zero_;
    last_ = x;
    extreme(x);
    ++count_;
    if (measure_->reduce == Reduce::quantile) all_.push_back(x);
  }

  const Measure* measure_;
  long count_ = 0;
  double zero_ = 0, t_ = 0, d_ = 0;
  double weight_ = 0, area_ = 0, squares_ = 0;
  double low_ = INFINITY, high_ = -INFINITY, first_ = NAN, last_ = NAN;
  std::vector<double> all_;
};

struct Result;
struct Scene;
class Simulation;

/// The evaluated part of a run.
struct CountedTime {
  double from = 0, to = 0;  ///< s
  double period = 0;        ///< s; 0 if unknown
};

/// Value of one measure.
struct MeasureValue {
  double value = 0;  ///< NaN if absent
  /// The value of one period or section point.
  struct Part {
    double t = 0, value = 0;  ///< s, beginning of a period, or time of a section point
  };
  std::vector<Part> parts;  ///< values of the periods or section points
};

/// Evaluates all measures of a study in one run.
class Measurer {
 public:
  /// Throws SceneError, with the position in the study, for a measure that the scene cannot
  /// provide.
  Measurer(const Study& study, const Scene& scene, const Layout& layout, CountedTime time);
  ~Measurer();
  Measurer(const Measurer&) = delete;
  Measurer& operator=(const Measurer&) = delete;

  /// Observers for all runs of the simulation up to the end of the window.
  std::vector<Observer*> observers() const;
  /// Time (s) before which these need no step, except the last one before it and the steps of events.
  double next_shown() const;
  /// Those that need the states of all steps.
  std::vector<Observer*> followers() const;
  /// Measures whose column is in no table, and may be a number of run.json.
  std::vector<Measure> numbers_of_runs() const;
  /// The values after the last run, in the order of the study. `result`: of that run.
  std::vector<MeasureValue> finish(Result result) const;

 private:
  class Statistics;
  class Track;
  class Rows;
  class Points;
  std::vector<std::unique_ptr<Track>> tracks_;  // one for each measure
  std::unique_ptr<Rows> rows_;
  std::vector<std::unique_ptr<Points>> points_;
  std::unique_ptr<Statistics> statistics_;
};

/// All numbers in run.json, by path. Paths of numbers of a contact begin with the contact's name.
std::map<std::string, double> numbers_of(const Result& result);

/// Throws SceneError if the column of a measure does not exist, with suggestions and a list of the
/// columns. `simulation` must be at its start; it is run for zero time.
void require_columns(const Study& study, const Scene& scene, Simulation& simulation, CountedTime time);

}  // namespace freeplay
