// Panels in a grid of rows and columns, over one abscissa or each over its own, laid out such that
// no text overlaps another or the edge of the page: margins follow the labels of the tics, keys have
// the rows that their titles need and stand above their panels, titles of axes break before the
// unit, and a panel is as high as its title. A grid whose panels are narrower than their labels
// has fewer columns.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "plots/drawing/axis.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/style.hpp"

namespace freeplay::plots {

/// A curve of a panel.
struct PanelCurve {
  Script what;        ///< data and style: DATA index 0 using 1:2 with lines
  std::string title;  ///< in the key; "": none
  Word symbol{""};    ///< shown instead of the title, with markup
};

/// The horizontal axis of a panel, or its scale of colours.
struct Abscissa {
  AxisTitle title;
  Axis axis;
};

/// A panel: its vertical axis and curves.
struct Panel {
  AxisTitle title;
  Axis axis;
  std::vector<PanelCurve> curves;
  std::string name = {};  ///< above the panel
  std::optional<Abscissa> abscissa = {};
  std::optional<Abscissa> colours = {};  ///< on the right, one for neighbours of the same scale
  Script before = {};                    ///< commands before the curves
};

/// The panels of a figure, row by row from the top.
struct PanelStack {
  Abscissa abscissa;  ///< of all panels without their own
  std::vector<Panel> panels;
  double each = 3.1;          ///< cm, height of a panel in a figure of usual width
  bool equal_scales = false;  ///< one panel whose axes have the same scale
  /// Panels side by side, at most. A title that a panel shares with its left neighbour is not
  /// repeated.
  std::size_t columns = 1;
  std::vector<PanelCurve> key = {};  ///< above the grid, of curves in all panels: with lines …
};

/// Adds a block to the figure and its curve to the panel, unless it has no rows. `how`: using 1:2 with lines.
void add_curve(Figure& figure, Panel& panel, Block block, const Script& how, std::string title = "");

/// The title of an axis of time, and of the crank angle.
AxisTitle time_title();
AxisTitle crank_title();

/// Adds the commands to the script of the figure and sets its size. The figure's title is centred above
/// keys and panels, in up to three lines.
void add_panels(Figure& figure, const Style& style, PanelStack stack);
/// The same, and draws the figure of the folder in its style; returns the path.
std::filesystem::path draw_panels(Figure& figure, const std::filesystem::path& folder, PanelStack stack);

/// Rows of a key whose titles are above a plot of this width (letters), and its columns.
struct KeyGrid {
  std::size_t rows = 0, columns = 1;
};
KeyGrid key_grid(const std::vector<std::string>& titles, double width);

}  // namespace freeplay::plots
