#include "plots/drawing/heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "mechanism/error.hpp"
#include "plots/drawing/panels.hpp"

namespace freeplay::plots {
namespace {

/// Perceptually uniform from dark to light (viridis, public domain), so that it reads in grey.
constexpr Word palette =
    "set palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 '#fde725')\n";
constexpr Word grey_palette = "set palette defined (0 '#202020', 1 '#f0f0f0')\n";
constexpr double most_linear_ratio = 100;  ///< of a colour scale

/// Distinct values of a coordinate.
std::vector<double> distinct(const HeatMap& map, std::size_t column) {
  std::vector<double> values;
  for (const auto& panel : map.panels)
    for (const auto& c : panel.cells) values.push_back(c[column]);
  std::ranges::sort(values);
  const auto [first, last] = std::ranges::unique(values);
  values.erase(first, last);
  return values;
}

/// Edges of the cells: midway between neighbours, at the ends as far out as in.
std::vector<double> edges_of(const std::vector<double>& values, bool logarithmic) {
  std::vector<double> at(values);
  if (logarithmic)
    for (double& x : at) x = std::log(x);
  std::vector<double> edges;
  for (std::size_t i = 0; i + 1 < at.size(); ++i) edges.push_back(0.5 * (at[i] + at[i + 1]));
  const double first = edges.empty() ? 0.5 : edges.front() - at.front(),
               last = edges.empty() ? 0.5 : at.back() - edges.back();
  edges.insert(edges.begin(), at.front() - first);
  edges.push_back(at.back() + last);
  if (logarithmic)
    for (double& x : edges) x = std::exp(x);
  return edges;
}

/// Whether the cells of these values would differ so much in width that their tics or the narrow
/// ones could not be read.
bool unequal(std::vector<double> values, bool logarithmic) {
  constexpr double most_ratio = 1.5;
  if (logarithmic)
    for (double& x : values) x = std::log(x);
  double least = INFINITY, greatest = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    least = std::min(least, values[i] - values[i - 1]);
    greatest = std::max(greatest, values[i] - values[i - 1]);
  }
  return values.size() > 2 && greatest > most_ratio * least;
}

/// One axis of a grid with the edges of its cells.
struct GridAxis {
  std::vector<double> edges;
  Axis axis;
};

GridAxis grid_axis(const std::vector<double>& values) {
  const bool logarithmic = is_logarithmic(values);
  GridAxis grid;
  if (unequal(values, logarithmic)) {  // equal cells by number, with their values as tics
    grid.edges.push_back(-0.5);
    for (const double x : values) {
      const double k = grid.edges.back() + 0.5;
      grid.axis.tics.push_back({k, fmt::format("{:.6g}", x)});
      grid.edges.push_back(k + 0.5);
    }
  } else {
    grid.edges = edges_of(values, logarithmic);
    grid.axis = axis_at(values);
  }
  grid.axis.low = grid.edges.front(), grid.axis.high = grid.edges.back();
  return grid;
}

/// An axis over points that form no grid, with margins.
Axis scattered_axis(const std::vector<double>& values) {
  if (is_logarithmic(values)) return decades_of(values.front(), values.back());
  const double margin = 0.03 * (values.back() - values.front());
  auto axis = axis_of(values.front(), values.back());
  if (margin > 0) axis.low = values.front() - margin, axis.high = values.back() + margin;
  return axis;
}

/// The axis of a scale of colours.
Axis colour_axis(const Limits& values) {
  if (values.least > 0 && values.most > most_linear_ratio * values.least)
    return {values.least, values.most, 0, true};
  const double half = values.range() > 0 ? 0 : 0.5 * std::max(std::abs(values.most), 1e-12);
  return {values.least - half, values.most + half};
}

}  // namespace

bool is_logarithmic(std::vector<double> values) {
  std::ranges::sort(values);
  if (values.size() < 3 || values.front() <= 0 || values.back() < 10 * values.front()) return false;
  std::vector<double> steps, ratios;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] == values[i - 1]) continue;
    steps.push_back(values[i] - values[i - 1]);
    ratios.push_back(std::log(values[i] / values[i - 1]));
  }
  const auto spread = [](const std::vector<double>& list) {
    const auto [least, greatest] = std::ranges::minmax_element(list);
    return *greatest / *least;
  };
  return spread(ratios) < spread(steps);
}

Axis axis_at(std::vector<double> values) {
  constexpr std::size_t most_tics = 7;
  std::ranges::sort(values);
  const auto [first, last] = std::ranges::unique(values);
  values.erase(first, last);
  Axis axis{values.front(), values.back(), 0, is_logarithmic(values)};
  if (values.size() <= most_tics || axis.logarithmic)
    for (const double x : values) axis.tics.push_back({x, fmt::format("{:.6g}", x)});
  return axis;
}

void add_heat_map(Figure& f, const HeatMap& map, const Style& style) {
  const auto count = map.panels.size();
  if (count > most_heat_panels)
    throw SceneError(
        fmt::format("{} maps, but a figure has at most {}; draw fewer measures, or curves by --x AXIS", count,
                    most_heat_panels));
  std::map<std::string, Limits> ranges;  // panels of one quantity share their scale
  for (const auto& panel : map.panels)
    for (const auto& c : panel.cells) ranges[panel.quantity.text.text()].hold(c[2]);
  if (std::ranges::all_of(ranges, [](const auto& r) { return !(r.second.range() >= 0); }))
    throw SceneError("no run has a value of the measure");
  const auto xs = distinct(map, 0), ys = distinct(map, 1);
  const auto x_grid = map.grid ? grid_axis(xs) : GridAxis{{}, scattered_axis(xs)},
             y_grid = map.grid ? grid_axis(ys) : GridAxis{{}, scattered_axis(ys)};
  f.script.add("{}unset grid\nset tics front\n", style.monochrome ? grey_palette : palette);
  PanelStack stack{.abscissa = {},
                   .panels = {},
                   .each = count == 1 ? 6.5 : 5.0,
                   .columns = count == 1 ? std::size_t{1} : std::size_t{2}};
  for (const auto& panel : map.panels) {
    Block block(fmt::format("{}: {}", panel.title.empty() ? panel.name : panel.title, map.heading) +
                (map.grid ? ", edges of the cell" : ""));
    for (auto cell : panel.cells) {
      if (!std::isfinite(cell[2])) continue;
      if (map.grid) {
        const auto i = static_cast<std::size_t>(std::ranges::lower_bound(xs, cell[0]) - xs.begin()),
                   j = static_cast<std::size_t>(std::ranges::lower_bound(ys, cell[1]) - ys.begin());
        cell.insert(cell.end(), {x_grid.edges[i], x_grid.edges[i + 1], y_grid.edges[j], y_grid.edges[j + 1]});
      }
      block.row(cell);
    }
    const auto last =
        map.panels.front().cells.empty() ? std::size_t{3} : map.panels.front().cells.front().size();
    Script what;
    if (map.grid)
      what.add(
          "DATA index {0} using (0.5*(${1}+${2})):(0.5*(${3}+${4})):{1}:{2}:{3}:{4}:3 with boxxyerror fs "
          "solid noborder lc palette",
          f.blocks.size(), last + 1, last + 2, last + 3, last + 4);
    else
      what.add("DATA index {} using 1:2:3 with points pt 7 ps 1.2 lc palette", f.blocks.size());
    stack.panels.push_back(
        {.title = map.y,
         .axis = y_grid.axis,
         .curves = {{what, ""}},
         .name = panel.title,
         .abscissa = Abscissa{map.x, x_grid.axis},
         .colours = Abscissa{panel.quantity, colour_axis(ranges[panel.quantity.text.text()])}});
    f.blocks.push_back(std::move(block));
  }
  add_panels(f, style, std::move(stack));
}

}  // namespace freeplay::plots
