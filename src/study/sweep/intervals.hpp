// Statistics of the cells of a study over their perturbed starts. For n values with mean x̄ and
// standard deviation s, the 95 % confidence interval of the mean is x̄ ± t_{n−1}(0.975) s/√n
// (Student). Directions are averaged on the circle; positive values and shares use a transformed
// scale if the interval would leave their range.
#pragma once

#include <functional>
#include <map>
#include <tuple>

#include "study/store/results.hpp"

namespace freeplay {

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
