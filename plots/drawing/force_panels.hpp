// Panels of forces: their ranges, and curves one above the other over the same angle or time. Impacts make
// rare means far beyond all others: ranges follow a quantile where these would flatten the rest, and the
// figure says how many points lie outside.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plots/drawing/script.hpp"
#include "plots/tables/force_table.hpp"

namespace freeplay::plots {

/// Of an axis, in the unit of its quantity.
struct ForceRange {
  double low = 0, high = 0;
  std::vector<std::size_t> outside;  ///< points of each run
};

/// Of one quantity in all runs. Its extremes, unless they are thrice as far apart as the quantiles.
ForceRange range_of(const std::vector<Values>& runs);
/// Widens a range about its middle until it is `least` long: rounding errors are not to fill a panel.
void widen(ForceRange& range, double least);
/// Greatest size of a finite value; 0 without one.
double greatest(const std::vector<Values>& runs);

struct ForcePanel {
  Word quantity;             ///< with its unit, left of the panel
  std::string name;          ///< what stands above it
  std::vector<Values> runs;  ///< of each run of the table; empty where one has none of it
  bool from_zero = false;
};

/// Draws panels one above the other, none shorter than `least` in its own unit. Those without values are left
/// out; an empty path when none is left.
std::filesystem::path stack(const ForceTable& table, const std::filesystem::path& folder,
                            const std::string& name, const std::string& heading,
                            std::vector<ForcePanel> panels, double least);

}  // namespace freeplay::plots
