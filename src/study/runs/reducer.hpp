// Reducer: accumulates the values of one column and computes a measure from them
// (study/settings/measure.hpp). The first value x₀ is subtracted before summation, so that small
// deviations from a large mean keep their digits:
//
//     d = x − x₀,   mean = x₀ + ∫d/T,   var = ∫d²/T − (∫d/T)²,   rms² = mean² + var.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "measure/turns.hpp"
#include "study/settings/measure.hpp"

namespace freeplay {

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

}  // namespace freeplay
