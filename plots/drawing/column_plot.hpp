// A figure of chosen columns of one or more runs: stacked panels, with one curve per column and
// run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plots/drawing/style.hpp"
#include "plots/tables/columns.hpp"

namespace freeplay::plots {

struct ColumnPlot {
  std::vector<std::filesystem::path> folders;    ///< result folders; the first receives the figure
  std::string x = "t";                           ///< column or expression
  std::vector<std::vector<std::string>> panels;  ///< columns or expressions; one panel per unit
  /// [AXIS=]UNIT, AXIS: x, y, y1 … y6. Without an axis: for each axis of this dimension.
  std::vector<std::string> units = {};
  bool fold = false;                         ///< x is an angle, shown within one turn
  std::optional<double> from = {}, to = {};  ///< s
  std::optional<Crossing> section = {};
  std::string name = {};             ///< of the files; empty: derived from the columns
  std::string title = {};            ///< above the panels; empty: none
  std::vector<Format> formats = {};  ///< empty: those of the style
};

/// Draws the figure and returns the path of its first format. Throws SceneError for unknown
/// columns.
std::filesystem::path draw_columns(const ColumnPlot& plot);

/// Parses COLUMN=VALUE, optionally followed by :up or :down. Throws SceneError.
Crossing crossing_of(const std::string& text);

/// Reduces a curve to fewer points that look the same on paper. A curve over time keeps the first,
/// last, least and greatest point of each interval; other curves keep every n-th point.
Points thinned(const Points& points, std::size_t most);

}  // namespace freeplay::plots
