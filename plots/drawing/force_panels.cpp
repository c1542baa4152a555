// Ranges that are robust against impact peaks, and the figure of stacked panels.
#include "plots/drawing/force_panels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"

namespace freeplay::plots {
namespace {

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

Axis across(const ForceTable& table) {
  if (table.turns()) return {.low = 0, .high = 360, .turn = true};
  double end = 0;
  for (const auto& run : table.runs()) end = std::max(end, run.t.back());
  return {0, end};
}

}  // namespace

void widen(ForceRange& range, double least) {
  const double lack = least - (range.high - range.low);
  if (!(lack > 0)) return;
  range.low -= 0.5 * lack;
  range.high += 0.5 * lack;
}

ForceRange range_of(const std::vector<Values>& runs) {
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

double greatest(const std::vector<Values>& runs) {
  double g = 0;
  for (const auto& values : runs)
    for (double x : values)
      if (std::isfinite(x)) g = std::max(g, std::abs(x));
  return g;
}

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
    auto range = range_of(p.runs);
    widen(range, least);
    if (p.from_zero) range.low = 0;
    if (const auto outside = note(range, runs); !outside.empty())
      f.caption += fmt::format(" Outside the range of panel {}: {}.", k + 1, outside);
    Panel panel{.title = AxisTitle::of(p.quantity, p.unit),
                .axis = {range.low, range.high},
                .curves = {},
                .name = p.name};
    for (int style : {1, 2, 3})
      for (std::size_t r = 0; r < runs.size(); ++r)
        if (runs[r].style == style && !p.runs[r].empty())
          panel.curves.push_back({Script().add("DATA index {} using 1:{} with lines ls {}{}", r, k + 2, style,
                                               runs.size() == 1 ? Word(" lw 1.1 dt 1")
                                               : style == 3     ? Word(" lw 1.4")
                                                                : Word(" lw 1.1")),
                                  k == 0 && runs.size() > 1 ? runs[r].title : ""});
    stack.panels.push_back(std::move(panel));
  }
  add_panels(f, style_of(folder), std::move(stack));
  return draw(f, folder);
}

}  // namespace freeplay::plots
