// Forces of joints and drives: reactions and driving torques over the crank angle, and polar load
// diagrams of the revolute joints, both formulations over the ideal mechanism. A driven mechanism
// is shown over its last whole turn, others over the whole run.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "plots/drawing/axis.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/gnuplot.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/force_table.hpp"

namespace freeplay::plots {
namespace {

// Panels of forces: their ranges, and stacked panels of curves over the same angle or time. Impacts
// cause rare means far beyond all others. Where these would flatten the rest of a curve, the range
// follows a quantile and the figure states how many points are outside.

/// Range of an axis, in the unit of its quantity.
struct ForceRange {
  double low = 0, high = 0;
  std::vector<std::size_t> outside;  ///< number of points outside, per run
};

struct ForcePanel {
  Word quantity;
  std::string unit;
  std::string name;          ///< title above the panel
  std::vector<Values> runs;  ///< per run of the table; empty if the run has no such quantity
  bool from_zero = false;
};

/// quantile of the upper end of a range; the lower end is 1 − share
constexpr double share = 0.99;

/// Text with the number of points of each run outside the range.
std::string note(const ForceRange& range, const std::vector<ForceRun>& runs) {
  std::string list;
  for (std::size_t r = 0; r < range.outside.size(); ++r)
    if (range.outside[r] > 0)
      list += fmt::format("{}{} {} of {}", list.empty() ? "" : ", ", runs[r].title, range.outside[r],
                          runs[r].x.size());
  return list;
}

/// Data block of a run: x and the quantities of the panels, with a gap where the angle wraps.
Block block_of(const ForceTable& table, std::size_t r, const std::vector<ForcePanel>& panels) {
  const auto& run = table.runs()[r];
  std::string heading = fmt::format("{}: {}", run.title, table.turns() ? "angle (degrees)" : "t (s)");
  for (const auto& p : panels)
    heading += ", " + (p.name.empty() ? "" : p.name + " ") + p.quantity.text() + " (" + p.unit + ")";
  Block block(heading);
  for (std::size_t i = 0; i < run.x.size(); ++i) {
    if (table.turns() && i > 0 && std::abs(run.x[i] - run.x[i - 1]) > 180) block.gap();
    std::vector<double> row{run.x[i]};
    for (const auto& p : panels)
      row.push_back(p.runs[r].empty() ? std::numeric_limits<double>::quiet_NaN() : p.runs[r][i]);
    block.row(row);
  }
  return block;
}

/// A mark at the edge of a panel for each peak of a curve beyond it: x, y, and +1 above or −1 below.
std::vector<std::array<double, 3>> clipped_peaks(const Values& x, const Values& y, const ForceRange& range) {
  const auto beyond = [&](double v) { return v > range.high ? 1 : v < range.low ? -1 : 0; };
  const double inside = 0.03 * (range.high - range.low);
  std::vector<std::array<double, 3>> marks;
  for (std::size_t i = 0; i < y.size();) {
    const int side = beyond(y[i]);
    std::size_t peak = i, end = i + 1;
    if (side != 0)
      for (; end < y.size() && beyond(y[end]) == side && std::abs(x[end] - x[end - 1]) <= 180; ++end)
        if (side * y[end] > side * y[peak]) peak = end;
    if (side != 0)
      marks.push_back({x[peak], side > 0 ? range.high - inside : range.low + inside, double(side)});
    i = end;
  }
  return marks;
}

Axis across(const ForceTable& table) {
  if (table.turns()) return {.low = 0, .high = 360, .turn = true};
  double end = 0;
  for (const auto& run : table.runs()) end = std::max(end, run.t.back());
  return {0, end};
}

/// Widens a range about its middle to a length of at least `least`, so that rounding errors do not
/// fill a panel.
void widen(ForceRange& range, double least) {
  const double lack = least - (range.high - range.low);
  if (!(lack > 0)) return;
  range.low -= 0.5 * lack;
  range.high += 0.5 * lack;
}

/// Range of one quantity over all runs: the extremes, unless they are more than three times as far
/// apart as the quantiles.
ForceRange common_range(const std::vector<Values>& runs) {
  ForceRange range;
  double low = INFINITY, high = -INFINITY, least = INFINITY, most = -INFINITY;
  for (const auto& values : runs) {
    Values v;
    std::ranges::copy_if(values, std::back_inserter(v), [](double x) { return std::isfinite(x); });
    if (v.empty()) continue;
    std::ranges::sort(v);
    const auto tail = static_cast<std::size_t>((1 - share) * static_cast<double>(v.size()));
    low = std::min(low, v[tail]);
    high = std::max(high, v[v.size() - 1 - tail]);
    least = std::min(least, v.front());
    most = std::max(most, v.back());
  }
  if (!(least <= most)) return {0, 1, {}};
  if (most - least <= 3 * (high - low) || high == low) low = least, high = most;
  const double margin = 0.06 * (high - low);
  range.low = low - margin;
  range.high = high + margin;
  // A constant force has no range, nor has one that varies less than the digits of the script.
  const double size = std::max(std::abs(low), std::abs(high));
  if (const double least_range = size > 0 ? 0.1 * size : 1; high - low < 1e-3 * size || size == 0)
    widen(range, least_range);
  for (const auto& values : runs)
    range.outside.push_back(static_cast<std::size_t>(
        std::ranges::count_if(values, [&](double x) { return x < range.low || x > range.high; })));
  return range;
}

/// Greatest magnitude of the finite values; 0 if there is none.
double greatest(const std::vector<Values>& runs) {
  double g = 0;
  for (const auto& values : runs)
    for (double x : values)
      if (std::isfinite(x)) g = std::max(g, std::abs(x));
  return g;
}

/// Draws stacked panels. The range of each is at least `least` in its unit. Panels without values
/// are omitted; the path is empty if no panel remains. The caption consists of the heading, the
/// span, and the number of points outside the ranges.
std::filesystem::path stack(const ForceTable& table, const std::filesystem::path& folder,
                            const std::string& name, const std::string& heading,
                            std::vector<ForcePanel> panels, double least) {
  std::erase_if(panels, [](const ForcePanel& p) {
    return std::ranges::all_of(p.runs, [](const Values& v) { return v.empty(); });
  });
  if (panels.empty()) return {};
  const auto& runs = table.runs();
  Figure f{.name = name, .source = table.source()};
  f.caption = fmt::format("{}{}{}{}.", heading, heading.empty() ? "" : "; ", table.extent(),
                          runs.size() == 1 ? fmt::format(", {}", runs[0].title) : "");
  for (std::size_t r = 0; r < runs.size(); ++r) f.blocks.push_back(block_of(table, r, panels));
  PanelStack stack{.abscissa = {table.turns() ? crank_title() : time_title(), across(table)},
                   .panels = {},
                   .each = panels.size() == 1  ? 6.5
                           : panels.size() < 5 ? 3.1
                                               : 2.6};
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const auto& p = panels[k];
    auto range = common_range(p.runs);
    widen(range, least);
    if (p.from_zero) range.low = 0;
    if (const auto outside = note(range, runs); !outside.empty())
      f.caption += fmt::format(" Outside the range of panel {} (triangles): {}.", k + 1, outside);
    Panel panel{.title = AxisTitle::of(p.quantity, p.unit),
                .axis = {range.low, range.high},
                .curves = {},
                .name = p.name};
    // The thin dashed curve of the nonsmooth formulation is above the wider one of penalty and shows it.
    for (int style : {1, 2, 3})
      for (std::size_t r = 0; r < runs.size(); ++r)
        if (runs[r].style == style && !p.runs[r].empty())
          panel.curves.push_back({Script().add("DATA index {} using 1:{} with lines ls {}{}", r, k + 2, style,
                                               runs.size() == 1 ? Word(" lw 1.1 dt 1")
                                               : style == 2     ? Word(" lw 0.7")
                                                                : Word(" lw 1.4")),
                                  k == 0 && runs.size() > 1 ? runs[r].title : ""});
    for (std::size_t r = 0; r < runs.size(); ++r)
      for (const int side : {1, -1}) {
        Block marks(fmt::format("{}, panel {}: peaks {} the range, x, edge", runs[r].title, k + 1,
                                side > 0 ? "above" : "below"));
        for (const auto& [x, y, of] : clipped_peaks(runs[r].x, p.runs[r], range))
          if (of == side) marks.row({x, y});
        add_curve(
            f, panel, std::move(marks),
            Script().add("using 1:2 with points pt {} ps 0.7 lc rgb C{}", side > 0 ? 9 : 11, runs[r].style));
      }
    stack.panels.push_back(std::move(panel));
  }
  return draw_panels(f, folder, std::move(stack));
}

constexpr Word force_x{"F_x", "$F_x$"}, force_y{"F_y", "$F_y$"}, force{"|F|", "$|F|$"};

/// |F| and its components; for a guide with clearance |F| of all corners together and of each,
/// for a slot with clearance likewise of its sides.
std::filesystem::path reaction(const ForceTable& table, const std::filesystem::path& folder,
                               const std::string& name) {
  const auto size = table.magnitudes(name);
  const double rounding = std::max(1e-6 * greatest(size), 1e-9);
  std::vector<ForcePanel> panels;
  const bool slot = table.any(name + ".right.fx"),
             guide = slot || table.any(name + "." + guide_corners[0] + ".fx");
  panels.push_back({force, "N", slot ? "both sides" : guide ? "all corners" : "", size, true});
  if (guide) {
    for (const auto* corner : guide_corners)
      if (table.any(name + "." + corner + ".fx")) {
        std::string label = corner;
        std::ranges::replace(label, '_', ' ');
        panels.push_back({force, "N", label, table.magnitudes(name + "." + corner), true});
      }
  } else {
    // A component that consists of rounding errors, such as the moment of a revolute joint, has no
    // panel. Moments are compared with forces, because their arms are of the order of a metre or
    // less.
    for (const auto& [quantity, unit, suffix] :
         {std::tuple{force_x, "N", ".fx"}, {force_y, "N", ".fy"}, {Word("M", "$M$"), "N m", ".m"}})
      if (auto v = table.columns(name, suffix); greatest(v) > rounding)
        panels.push_back({quantity, unit, "", std::move(v), false});
  }
  return stack(table, folder, file_name("reaction", name), table.heading(name), std::move(panels), rounding);
}

std::filesystem::path drive_torque(const ForceTable& table, const std::filesystem::path& folder) {
  std::vector<ForcePanel> panels;
  double size = 0;
  for (const auto& name : table.drives()) {
    panels.push_back({{"torque M", "torque $M$"},
                      "N m",
                      table.drives().size() > 1 ? name : "",
                      table.columns(name, ".torque"),
                      false});
    size = std::max(size, greatest(panels.back().runs));
  }
  return stack(table, folder, "drive_torque", fmt::format("torque of {}", fmt::join(table.drives(), ", ")),
               std::move(panels), std::max(1e-6 * size, 1e-9));
}

/// The share of a component within a range that contains 0: 1 inside.
double part_inside(double value, const ForceRange& range) {
  return value > range.high ? range.high / value : value < range.low ? range.low / value : 1;
}

/// F_y over F_x: one panel per formulation, each with the ideal joint.
std::filesystem::path bearing_load(const ForceTable& table, const std::filesystem::path& folder,
                                   const std::string& name) {
  const auto& runs = table.runs();
  const auto x = table.columns(name, ".fx"), y = table.columns(name, ".fy");
  auto across = common_range(x), up = common_range(y);
  // The range contains the origin; both axes have the same scale.
  for (auto* range : {&across, &up}) {
    const double margin = 0.06 * (range->high - range->low);
    range->low = std::min(range->low, -margin);
    range->high = std::max(range->high, margin);
  }
  const double span = std::max({across.high - across.low, up.high - up.low, 1e-9});
  widen(across, span);
  widen(up, span);

  Figure f{.name = file_name("bearing_load", name), .height_cm = 9, .source = table.source()};
  std::vector<std::size_t> panels;
  std::optional<std::size_t> ideal;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    auto& block = f.blocks.emplace_back(fmt::format("{}: F_x, F_y (N)", runs[r].title));
    for (std::size_t i = 0; i < std::min(x[r].size(), y[r].size()); ++i) block.row({x[r][i], y[r][i]});
    if (x[r].empty() || y[r].empty()) continue;
    if (runs[r].style == 3)
      ideal = r;
    else
      panels.push_back(r);
  }
  if (panels.empty()) return {};
  // Square panels: side by side on a wide page, one above the other on a narrow one.
  const auto style = style_of(folder);
  const double scale = style.font_size / Style::usual_font_size;
  f.width_cm = style.width ? 0.1 * *style.width : panels.size() == 1 ? 9 : 16;
  const auto side_of = [&](double columns) {
    return (f.width_cm - scale * (1.75 + 0.45 + 1.9 * (columns - 1))) / columns;
  };
  const auto columns = side_of(static_cast<double>(panels.size())) < 4.5 * scale ? 1 : panels.size(),
             rows = panels.size() / columns;
  const auto lines = static_cast<double>(rows);
  const double side = std::max(side_of(static_cast<double>(columns)), 1.0), key = ideal ? 0.42 : 0,
               title = panels.size() > 1 ? 0.5 : 0.15;
  f.height_cm = lines * side + scale * (key + title + 1.2 + (lines - 1) * (1.2 + title));
  f.sized = true;
  f.caption = fmt::format("{}; {}.", table.heading(name), table.extent());
  const double tics = with_tics({across.low, across.high}, 8, side / scale / letter_width).step;
  f.script.add(
      "set multiplot layout {},{} margins X(1.75),1-X(0.45),Y(1.2),1-Y({}) spacing X(1.9),Y({})\nset size "
      "ratio -1\n"
      "set xrange [{:.5g}:{:.5g}]\nset yrange [{:.5g}:{:.5g}]\nset xlabel {}\n"
      "set xtics {:.6g}\nset ytics {:.6g}\nset ylabel {}\nset xzeroaxis ls 4\nset yzeroaxis ls 4\n"
      "set key at screen 0.5,1-Y(0.1) center top\nset title offset 0,-0.6\n",
      rows, columns, key + title, 1.2 + title, across.low, across.high, up.low, up.high,
      AxisTitle::of(force_x, "N").label(99), tics, tics, AxisTitle::of(force_y, "N").label(99));
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const auto r = panels[k];
    std::size_t outside = 0;
    Block peaks(fmt::format("{}: peaks outside, arrow to the edge: x, y, length along x, y", runs[r].title));
    double least = 1;  // of the shares of the present peak that are inside
    std::size_t peak = 0;
    for (std::size_t i = 0; i <= x[r].size(); ++i) {
      const double inside =
          i < x[r].size() ? std::min(part_inside(x[r][i], across), part_inside(y[r][i], up)) : 1;
      outside += inside < 1;
      if (inside < least) least = inside, peak = i;
      if (inside < 1 || least == 1) continue;
      const double to_x = least * x[r][peak], to_y = least * y[r][peak],
                   length = 0.05 * span / std::hypot(to_x, to_y);
      peaks.row({to_x * (1 - length), to_y * (1 - length), to_x * length, to_y * length});
      least = 1;
    }
    if (outside > 0)
      f.caption +=
          fmt::format(" Outside the ranges (arrows): {} {} of {}.", runs[r].title, outside, x[r].size());
    if (panels.size() > 1) f.script.add("set title {}\n", runs[r].title);
    f.script.add("plot DATA index {} using 1:2 with lines ls {} lw 0.8 dt 1 notitle", r, runs[r].style);
    if (ideal)
      f.script.add(", DATA index {} using 1:2 with lines ls 3 lw 1.4 {}", *ideal,
                   k == 0 ? Word("title 'ideal joint'") : Word("notitle"));
    if (!peaks.empty()) {
      f.script.add(
          ", DATA index {} using 1:2:3:4 with vectors filled head size screen X(0.14),20 fixed lw 0.8 lc rgb "
          "C{} notitle",
          f.blocks.size(), runs[r].style);
      f.blocks.push_back(std::move(peaks));
    }
    f.script.add("\n");
  }
  f.script.add("unset multiplot\n");
  return draw(f, folder);
}

std::vector<std::filesystem::path> draw_forces(const std::filesystem::path& folder) {
  const ForceTable table(folder);
  std::vector<std::filesystem::path> made;
  for (const auto& name : table.joints()) {
    made.push_back(reaction(table, folder, name));
    if (table.revolute(name)) made.push_back(bearing_load(table, folder, name));
  }
  made.push_back(drive_torque(table, folder));
  std::erase_if(made, [](const std::filesystem::path& path) { return path.empty(); });
  return made;
}

}  // namespace

const Drawing forces{{"comparison.json", "run.json"}, draw_forces};

}  // namespace freeplay::plots
