// Statistics of a study's cells over their perturbed starts.
#pragma once

#include <functional>
#include <map>
#include <tuple>

#include "study/store/results.hpp"

namespace freeplay {

/// Mean over starts with Student's 95 % interval of the mean, and the range.
struct Interval {
  int count = 0;
  double mean = 0, low = 0, high = 0;  ///< low and high are NaN for fewer than two
  double least = 0, greatest = 0;
  bool overlaps(const Interval& other) const { return low <= other.high && other.low <= high; }
};
/// Of the finite values.
Interval interval(const std::vector<double>& values);
/// Of directions in degrees: their mean direction, in [0, 360), and the rest by their deviations from it on the circle,
/// unwrapped about it: low may be below 0 and high beyond 360. An interval of half the circle or more says nothing:
/// NaN.
Interval interval_of_directions(const std::vector<double>& degrees);
/// The same interval of a mean on the scale where its values may lie: x > 0 by its logarithm, a share by its logit, so
/// that with h Student's half-width it is x e^(±h/x), or that of the odds; of a mean at an end of its range that end.
Interval within_range(Interval s, TurnMetrics::Kind kind);

/// The runs of one cell, on the circle where the statistic is a direction; where Student's interval would leave the range of its
/// values, on their scale.
Interval cell(const std::vector<RunRow>& runs, const std::string& variant, const std::string& formulation,
              const std::vector<double>& values, TurnMetrics::Name metric);

/// The runs of every cell, sought once: a study may have many thousand of both. The runs must outlive it.
class Cells {
 public:
  explicit Cells(const std::vector<RunRow>& runs);
  /// In the order of the runs; empty where there are none.
  const std::vector<const RunRow*>& at(const std::string& variant, const std::string& formulation,
                                       const std::vector<double>& values) const;
  /// Of that cell, as cell() has it.
  Interval of(const std::string& variant, const std::string& formulation, const std::vector<double>& values,
              TurnMetrics::Name metric) const;

 private:
  std::map<std::tuple<std::string, std::string, std::vector<double>>, std::vector<const RunRow*>> runs_;
};

}  // namespace freeplay
