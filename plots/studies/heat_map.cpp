#include "plots/studies/heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "mechanism/error.hpp"

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

/// One axis of a grid: the edges of its cells, and its commands.
struct GridAxis {
  std::vector<double> edges;
  Script script = {};
};

GridAxis grid_axis(const Word& axis, const std::vector<double>& values, bool logarithmic) {
  if (!unequal(values, logarithmic)) {
    GridAxis grid{edges_of(values, logarithmic)};
    grid.script.add("{}", axis_commands(axis, values, logarithmic))
        .add("set {}range [{:.8g}:{:.8g}]\n", axis, grid.edges.front(), grid.edges.back());
    return grid;
  }
  // Equal cells by number, with their values as tics.
  constexpr std::size_t most_tics = 8;
  GridAxis grid{{-0.5}};
  const auto each = (values.size() + most_tics - 1) / most_tics;
  grid.script.add("set {}tics (", axis);
  for (std::size_t i = 0; i < values.size(); ++i) {
    grid.edges.push_back(static_cast<double>(i) + 0.5);
    if (i % each != 0) continue;
    if (i > 0) grid.script.add(", ");
    grid.script.add_tic(fmt::format("{:.6g}", values[i]), i);
  }
  grid.script.add(")\nset {}range [{:.8g}:{:.8g}]\n", axis, grid.edges.front(), grid.edges.back());
  return grid;
}

struct ValueRange {
  double low = INFINITY, high = -INFINITY;
};

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

Script axis_commands(const Word& axis, std::vector<double> values, bool logarithmic) {
  constexpr std::size_t most_tics = 7;
  Script s;
  if (logarithmic) s.add("set logscale {}\n", axis);
  std::ranges::sort(values);
  const auto [first, last] = std::ranges::unique(values);
  values.erase(first, last);
  if (values.size() > most_tics) return s;
  s.add("set {}tics (", axis);
  for (std::size_t i = 0; i < values.size(); ++i) s.add("{}{:.6g}", i ? Word(", ") : Word(""), values[i]);
  return s.add(")\nset format {} '%g'\n", axis);
}

void add_heat_map(Figure& f, const HeatMap& map, const Style& style) {
  const auto count = map.panels.size();
  if (count > most_heat_panels)
    throw SceneError(
        fmt::format("{} maps, but a figure has at most {}; draw fewer measures, or curves by --x AXIS", count,
                    most_heat_panels));
  std::map<std::string, ValueRange> ranges;
  for (const auto& panel : map.panels)
    for (const auto& c : panel.cells) {
      if (!std::isfinite(c[2])) continue;
      auto& r = ranges[panel.quantity];
      r.low = std::min(r.low, c[2]);
      r.high = std::max(r.high, c[2]);
    }
  if (ranges.empty()) throw SceneError("no run has a value of the measure");
  const auto xs = distinct(map, 0), ys = distinct(map, 1);
  const bool log_x = is_logarithmic(xs), log_y = is_logarithmic(ys);
  const auto x_grid = grid_axis("x", xs, log_x), y_grid = grid_axis("y", ys, log_y);
  const bool one_column = count == 1 || is_narrow(f, style);
  const auto columns = one_column ? std::size_t{1} : std::size_t{2}, rows = (count + columns - 1) / columns;
  // Panels side by side with the same scale have one colour bar and one title of the ordinate.
  bool shared = columns == 2;
  for (std::size_t k = 0; k + 1 < count; k += 2)
    shared = shared && map.panels[k].quantity == map.panels[k + 1].quantity;
  f.height_cm = 3 + (count == 1 ? 6.5 : 5.5) * static_cast<double>(rows);
  f.script.add(
      "{}set multiplot layout {},{} margins X(1.9),1-X(2.5),Y(1.5),1-Y(0.9) spacing X({}),Y(2.2)\nunset key\nunset "
      "grid\nset tics front\nset xlabel {} noenhanced\nset ylabel {} noenhanced\n",
      style.monochrome ? grey_palette : palette, rows, columns, shared ? 1.5 : 4.1, map.x, map.y);
  if (map.grid)
    f.script.add("{}{}", x_grid.script, y_grid.script);
  else
    f.script.add("{}{}set offsets graph 0.03, graph 0.03, graph 0.03, graph 0.03\n",
                 log_x ? Word("set logscale x\n") : Word(""), log_y ? Word("set logscale y\n") : Word(""));
  for (std::size_t k = 0; k < count; ++k) {
    const auto& panel = map.panels[k];
    if (shared)
      f.script.add(
          "{}{}", k % 2 == 0 && k + 1 < count ? Word("unset colorbox\n") : Word("set colorbox\n"),
          k % 2 == 0 ? Script().add("set ylabel {} noenhanced\n", map.y) : Script().add("unset ylabel\n"));
    const auto& range = ranges[panel.quantity];
    const bool log_values = range.low > 0 && range.high > most_linear_ratio * range.low;
    const double half = range.high > range.low ? 0 : 0.5 * std::max(std::abs(range.high), 1e-12);
    f.script.add(
        "{}set cbrange [{:.8g}:{:.8g}]\nset cblabel {} noenhanced offset 0.8,0\nset title {} noenhanced offset 0,-0.8\n",
        log_values ? Word("set logscale cb\n") : Word("unset logscale cb\n"), range.low - half,
        range.high + half, panel.quantity, panel.title);
    Block block(fmt::format("{}: {}", panel.title.empty() ? panel.quantity : panel.title, map.heading) +
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
    if (map.grid)
      f.script.add(
          "plot DATA index {0} using (0.5*(${1}+${2})):(0.5*(${3}+${4})):{1}:{2}:{3}:{4}:3 with boxxyerror fs solid noborder lc palette\n",
          f.blocks.size(), last + 1, last + 2, last + 3, last + 4);
    else
      f.script.add("plot DATA index {} using 1:2:3 with points pt 7 ps 1.2 lc palette\n", f.blocks.size());
    f.blocks.push_back(std::move(block));
  }
  f.script.add("unset multiplot\n");
}

}  // namespace freeplay::plots
