// Heat maps: values in the cells of a grid over two axes, as coloured rectangles whose edges are
// midway between neighbouring values, or, for values of unequal distances, as equal rectangles; or
// coloured points for values that form no grid. Panels of the same quantity share one colour scale.
#pragma once

#include <string>
#include <vector>

#include "plots/drawing/axis.hpp"
#include "plots/drawing/figure.hpp"

namespace freeplay::plots {

struct HeatPanel {
  std::string title;   ///< above the panel; may be empty
  std::string name;    ///< of the quantity with its unit, for the data file
  AxisTitle quantity;  ///< of the colour scale
  /// x, y, value, and further columns that only the data file shows; values that are not finite are
  /// omitted
  std::vector<std::vector<double>> cells;
};

struct HeatMap {
  AxisTitle x, y;
  bool grid = true;
  std::string heading;  ///< names of the columns, for the data file
  std::vector<HeatPanel> panels;
};

/// The most panels of one figure.
inline constexpr std::size_t most_heat_panels = 6;

/// Adds blocks and commands to a figure, and sets its size. Throws SceneError if no cell has a
/// value, or for too many panels.
void add_heat_map(Figure& f, const HeatMap& map, const Style& style);

/// Whether values are better shown on a logarithmic axis: three or more positive values over a
/// decade or more, with ratios that differ less than their differences do.
bool is_logarithmic(std::vector<double> values);

/// An axis from the least to the greatest of these values, with tics at them if they are few or if
/// it is logarithmic.
Axis axis_at(std::vector<double> values);

}  // namespace freeplay::plots
