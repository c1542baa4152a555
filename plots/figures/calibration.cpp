// A calibration: the outcome of each target at every point over each unknown, with the measured
// value; and the misfit over each pair of unknowns, with the contours of 68 % and 95 % (two degrees
// of freedom: excess 2.30 and 5.99).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "plots/drawing/figure.hpp"
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
  const Table table(folder / "calibration.csv", {}, {"at", "outcome", "measured", "low", "high"},
                    {"target", "unknown"});
  const auto &target = table.text("target"), &unknown = table.text("unknown");
  const auto rows = distinct(target), columns = distinct(unknown);
  Figure f{.name = "calibration_targets", .source = "calibration.json"};
  f.height_cm = 3 + 4 * static_cast<double>(rows.size());
  f.script.add(
      "set multiplot layout {},{} margins X(2.2),1-X(0.5),Y(1.4),1-Y(0.5) spacing X(2),Y(1.3)\nunset key\n",
      rows.size(), columns.size());
  for (const auto& r : rows)
    for (const auto& c : columns) {
      Block points("unknown, outcome"), measured("unknown, measured, low, high");
      double least = INFINITY, greatest = -INFINITY, value = 0, low = 0, high = 0;
      for (std::size_t i = 0; i < table.rows(); ++i) {
        if (target[i] != r || unknown[i] != c) continue;
        points.row({table.column("at")[i], table.column("outcome")[i]});
        least = std::min(least, table.column("at")[i]);
        greatest = std::max(greatest, table.column("at")[i]);
        value = table.column("measured")[i];
        low = table.column("low")[i];
        high = table.column("high")[i];
      }
      if (points.empty()) continue;
      measured.row({least, value, low, high}).row({greatest, value, low, high});
      f.script.add(
          "set xlabel {} noenhanced\nset ylabel {} noenhanced\nset xtics {:.6g}\nplot DATA index {} using 1:3:4 with filledcurves fs "
          "transparent solid 0.25 noborder lc rgb C2, '' index {} using 1:2 with lines lc rgb C2, '' index {} using 1:2 "
          "with points pt 7 ps 0.35 lc rgb C1\n",
          c, r, tic_step(greatest - least), f.blocks.size() + 1, f.blocks.size() + 1, f.blocks.size());
      f.blocks.push_back(points);
      f.blocks.push_back(measured);
    }
  f.script.add("unset multiplot\n");
  return draw(f, folder);
}

std::vector<std::filesystem::path> misfit(const std::filesystem::path& folder) {
  const Table table(folder / "misfit.csv", {}, {"x", "y", "excess"}, {"x_name", "y_name"});
  const auto &x = table.column("x"), &y = table.column("y"), &excess = table.column("excess");
  const auto &x_name = table.text("x_name"), &y_name = table.text("y_name");
  Figure f{.name = "calibration_misfit", .source = "calibration.json"};
  struct Panel {
    std::string x, y;
    double left, right, bottom, top;
  };
  std::vector<Panel> panels;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (panels.empty() || panels.back().x != x_name[i] || panels.back().y != y_name[i]) {
      if (panels.size() == most_targets) break;
      panels.push_back({x_name[i], y_name[i], x[i], x[i], y[i], y[i]});
      f.blocks.emplace_back("x, y, f - min f");
    } else if (x[i] != x[i - 1]) {
      f.blocks.back().gap();
    }
    auto& p = panels.back();
    p.left = std::min(p.left, x[i]), p.right = std::max(p.right, x[i]);
    p.bottom = std::min(p.bottom, y[i]), p.top = std::max(p.top, y[i]);
    f.blocks.back().row({x[i], y[i], std::clamp(excess[i], -1e3, 1e3)});
  }
  if (panels.empty()) return {};
  f.height_cm = panels.size() > 2 ? 14 : 8;
  f.script.add("set contour base\nunset surface\n");
  for (std::size_t k = 0; k < panels.size(); ++k)
    f.script.add(
        "set cntrparam levels discrete 5.99\nset table $wide{}\nsplot DATA index {} using 1:2:3\nunset table\n"
        "set cntrparam levels discrete 2.30\nset table $near{}\nsplot DATA index {} using 1:2:3\nunset table\n",
        k, k, k, k);
  f.script.add(
      "unset contour\nset multiplot layout {},{} margins X(2.2),1-X(0.5),Y(1.4),1-Y(1.1) spacing X(2.2),Y(1.6)\n"
      "set key center at graph 0.5, graph 1.07 horizontal maxrows 1 samplen 2 font SMALL\n",
      panels.size() > 2 ? 2 : 1, panels.size() > 1 ? 2 : 1);
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const auto& p = panels[k];
    f.script.add(
        "set xlabel {} noenhanced\nset ylabel {} noenhanced\nset xrange [{}:{}]\nset yrange [{}:{}]\n"
        "plot $wide{} using 1:2 with lines lw 1.5 lc rgb C2 title {}, $near{} using 1:2 with lines lw 1.5 lc rgb C1 "
        "title {}\n",
        p.x, p.y, p.left, p.right, p.bottom, p.top, k, Word("'95 %'", "'95\\,\\%'"), k,
        Word("'68 %'", "'68\\,\\%'"));
  }
  f.script.add("unset multiplot\n");
  return {draw(f, folder)};
}

std::vector<std::filesystem::path> draw_calibration(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> all{targets(folder)};
  for (auto& path : misfit(folder)) all.push_back(path);
  return all;
}

}  // namespace

const Drawing calibration{{"calibration.csv"}, draw_calibration};

}  // namespace freeplay::plots
