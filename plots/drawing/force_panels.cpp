// Ranges that are robust against impact peaks, and the figure of stacked panels.
#include "plots/drawing/force_panels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "plots/drawing/figure.hpp"

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
  return list.empty() ? "" : "outside: " + list;
}

/// Data block of a run: x and the quantities of the panels, with a gap where the angle wraps.
Block block_of(const ForceTable& table, std::size_t r, const std::vector<ForcePanel>& panels) {
  const auto& run = table.runs()[r];
  std::string heading = fmt::format("{}: {}", run.title, table.turns() ? "angle (degrees)" : "t (s)");
  for (const auto& p : panels) heading += ", " + (p.name.empty() ? "" : p.name + " ") + p.quantity.text();
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

/// Commands for the range of the angle or time axis.
Script across(const ForceTable& table) {
  Script script;
  if (table.turns()) return script.add("set xrange [0:360]\nset xtics 45\n");
  double end = 0;
  for (const auto& run : table.runs()) end = std::max(end, run.t.back());
  return script.add("set xrange [0:{:.6g}]\n", end);
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
  const double each = panels.size() == 1 ? 6.5 : panels.size() < 5 ? 3.1 : 2.6;
  const double gap = 0.55, top = 1.45, bottom = 1.35;
  const double count = static_cast<double>(panels.size());
  f.height_cm = top + bottom + count * each + (count - 1) * gap;
  for (std::size_t r = 0; r < runs.size(); ++r) f.blocks.push_back(block_of(table, r, panels));
  f.script.add(
      "set multiplot layout {},1 margins X(1.7),1-X(0.5),Y({}),1-Y({}) spacing 0,Y({})\n"
      "set key at screen 1-X(0.5),1-Y(0.5) right top horizontal maxrows 1 samplen 2\n"
      "set label 1 {} at screen X(1.7),1-Y(0.3) noenhanced\nset format x ''\n{}",
      panels.size(), bottom, top, gap, heading, across(table));
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const auto& p = panels[k];
    auto range = range_of(p.runs);
    widen(range, least);
    if (p.from_zero) range.low = 0;
    if (k + 1 == panels.size()) f.script.add("set format x\nset xlabel {} noenhanced\n", table.abscissa());
    f.script.add(
        "set ylabel '{}'\nset yrange [{:.5g}:{:.5g}]\n"
        "set label 2 {} at graph 0, graph 1 offset 0,0.5 font SMALL noenhanced\n"
        "set label 3 {} at graph 1, graph 1 offset 0,0.5 right font TINY tc rgb 0x555555 noenhanced\n",
        p.quantity, range.low, range.high, p.name, note(range, runs));
    Script plot;
    for (int style : {1, 2, 3})
      for (std::size_t r = 0; r < runs.size(); ++r)
        if (runs[r].style == style && !p.runs[r].empty())
          plot.add("{}DATA index {} using 1:{} with lines ls {}{} title {}",
                   plot.empty() ? Word("plot ") : Word(", "), r, k + 2, style,
                   style == 3 ? Word(" lw 1.4") : Word(" lw 1.1"), runs[r].title);
    f.script.add("{}\n", plot);
    if (k == 0) f.script.add("unset key\nunset label 1\nunset label 100\n");
  }
  f.script.add("unset multiplot\n");
  return draw(f, folder);
}

}  // namespace freeplay::plots
