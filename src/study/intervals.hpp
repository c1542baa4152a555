// Statistics of a study's cells over their perturbed starts.
#pragma once

#include <functional>

#include "study/results.hpp"

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

/// The runs of one cell: those that `of` accepts.
Interval cell(const std::vector<RunRow>& runs, const std::string& variant, const std::string& formulation,
              const std::vector<double>& values, TurnMetrics::Name metric);

/// Each variant and cell on a line, for a terminal of 80 columns.
std::string sweep_table(const Study& study, const std::vector<RunRow>& runs);

}  // namespace freeplay
