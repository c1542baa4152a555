// Panels of forces: their ranges, and stacked panels of curves over the same angle or time. Impacts
// cause rare means far beyond all others. Where these would flatten the rest of a curve, the range
// follows a quantile and the figure states how many points are outside.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plots/drawing/gnuplot.hpp"
#include "plots/tables/force_table.hpp"

namespace freeplay::plots {

/// Range of an axis, in the unit of its quantity.
struct ForceRange {
  double low = 0, high = 0;
  std::vector<std::size_t> outside;  ///< number of points outside, per run
};

/// Range of one quantity over all runs: the extremes, unless they are more than three times as far
/// apart as the quantiles.
ForceRange range_of(const std::vector<Values>& runs);
/// Widens a range about its middle to a length of at least `least`, so that rounding errors do not
/// fill a panel.
void widen(ForceRange& range, double least);
/// Greatest magnitude of the finite values; 0 if there is none.
double greatest(const std::vector<Values>& runs);

struct ForcePanel {
  Word quantity;
  std::string unit;
  std::string name;          ///< title above the panel
  std::vector<Values> runs;  ///< per run of the table; empty if the run has no such quantity
  bool from_zero = false;
};

/// Draws stacked panels. The range of each is at least `least` in its unit. Panels without values
/// are omitted; the path is empty if no panel remains. The caption consists of the heading, the
/// span, and the number of points outside the ranges.
std::filesystem::path stack(const ForceTable& table, const std::filesystem::path& folder,
                            const std::string& name, const std::string& heading,
                            std::vector<ForcePanel> panels, double least);

}  // namespace freeplay::plots
