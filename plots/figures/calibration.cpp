// A calibration: the outcome of each target at every point over each unknown, with the measured
// value; and the misfit over each pair of unknowns, with the contours of 68 % and 95 % (two degrees
// of freedom: excess 2.30 and 5.99).
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t most_targets = 4;  // limit of targets and of unknowns in one figure

/// The first distinct texts, in their order.
std::vector<std::string> distinct(const std::vector<std::string>& list) {
  std::vector<std::string> names;
  for (const auto& x : list)
    if (std::ranges::find(names, x) == names.end() && names.size() < most_targets) names.push_back(x);
  return names;
}

std::filesystem::path targets(const std::filesystem::path& folder) {
  const ReadTable table(folder / "calibration.csv", {}, {"at", "outcome", "measured", "low", "high"},
                        {"target", "unknown", "target_unit", "unknown_unit"});
  const auto &target = table.text("target"), &unknown = table.text("unknown");
  const auto rows = distinct(target), columns = distinct(unknown);
  Figure f{.name = "calibration_targets", .source = "calibration.json"};
  PanelStack stack{.abscissa = {}, .panels = {}, .each = 3.2, .columns = columns.size()};
  for (const auto& r : rows)
    for (const auto& c : columns) {
      Block points("unknown, outcome"), measured("unknown, measured, low, high");
      Limits across, up;
      double value = 0, low = 0, high = 0;
      std::string target_unit, unknown_unit;
      for (std::size_t i = 0; i < table.rows(); ++i) {
        if (target[i] != r || unknown[i] != c) continue;
        points.row({table.column("at")[i], table.column("outcome")[i]});
        target_unit = table.text("target_unit")[i], unknown_unit = table.text("unknown_unit")[i];
        across.hold(table.column("at")[i]);
        value = table.column("measured")[i], low = table.column("low")[i], high = table.column("high")[i];
        for (const double y : {table.column("outcome")[i], value, low, high}) up.hold(y);
      }
      if (points.empty()) continue;
      measured.row({across.least, value, low, high}).row({across.most, value, low, high});
      const auto k = f.blocks.size();
      stack.panels.push_back(
          {.title = AxisTitle::plain(r, target_unit),
           .axis = axis_of(up.least, up.most),
           .curves = {{Script().add("DATA index {} using 1:3:4 with filledcurves fs transparent solid 0.25 "
                                    "noborder lc rgb C2",
                                    k + 1),
                       ""},
                      {Script().add("DATA index {} using 1:2 with lines lc rgb C2", k + 1), ""},
                      {Script().add("DATA index {} using 1:2 with points pt 7 ps 0.35 lc rgb C1", k), ""}},
           .abscissa = Abscissa{AxisTitle::plain(c, unknown_unit), axis_of(across.least, across.most)}});
      f.blocks.push_back(points);
      f.blocks.push_back(measured);
    }
  return draw_panels(f, folder, std::move(stack));
}

std::vector<std::filesystem::path> misfit(const std::filesystem::path& folder) {
  const ReadTable table(folder / "misfit.csv", {}, {"x", "y", "excess"}, {"x_name", "y_name"});
  const auto &x = table.column("x"), &y = table.column("y"), &excess = table.column("excess");
  const auto &x_name = table.text("x_name"), &y_name = table.text("y_name");
  const ReadTable points(folder / "calibration.csv", {}, {}, {"unknown", "unknown_unit"});
  const auto& unknowns = points.text("unknown");
  const auto titled = [&](const std::string& name) {
    const auto at = std::ranges::find(unknowns, name) - unknowns.begin();
    return AxisTitle::plain(name, static_cast<std::size_t>(at) == unknowns.size()
                                      ? ""
                                      : points.text("unknown_unit")[static_cast<std::size_t>(at)]);
  };
  Figure f{.name = "calibration_misfit", .source = "calibration.json"};
  struct Pair {
    std::string x, y;
    Limits across, up;
  };
  std::vector<Pair> panels;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (panels.empty() || panels.back().x != x_name[i] || panels.back().y != y_name[i]) {
      if (panels.size() == most_targets) break;
      panels.push_back({x_name[i], y_name[i], {}, {}});
      f.blocks.emplace_back("x, y, f - min f");
    } else if (x[i] != x[i - 1]) {
      f.blocks.back().gap();
    }
    auto& p = panels.back();
    p.across.hold(x[i]), p.up.hold(y[i]);
    f.blocks.back().row({x[i], y[i], std::clamp(excess[i], -1e3, 1e3)});
  }
  if (panels.empty()) return {};
  f.script.add("set contour base\nunset surface\n");
  for (std::size_t k = 0; k < panels.size(); ++k)
    f.script.add(
        "set cntrparam levels discrete 5.99\nset table $wide{}\nsplot DATA index {} using 1:2:3\nunset "
        "table\n"
        "set cntrparam levels discrete 2.30\nset table $near{}\nsplot DATA index {} using 1:2:3\nunset "
        "table\n",
        k, k, k, k);
  f.script.add("unset contour\nset surface\n");
  PanelStack stack{.abscissa = {}, .panels = {}, .each = 4.4, .columns = 2};
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const auto& p = panels[k];
    const bool keyed = k == 0;
    stack.panels.push_back(
        {.title = titled(p.y),
         .axis = {p.up.least, p.up.most},
         .curves = {{Script().add("$wide{} using 1:2 with lines lw 1.5 lc rgb C2", k), keyed ? "95 %" : ""},
                    {Script().add("$near{} using 1:2 with lines lw 1.5 lc rgb C1", k), keyed ? "68 %" : ""}},
         .abscissa = Abscissa{titled(p.x), {p.across.least, p.across.most}}});
  }
  return {draw_panels(f, folder, std::move(stack))};
}

std::vector<std::filesystem::path> draw_calibration(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> all{targets(folder)};
  for (auto& path : misfit(folder)) all.push_back(path);
  return all;
}

}  // namespace

const Drawing calibration{{"calibration.csv"}, draw_calibration};

}  // namespace freeplay::plots
