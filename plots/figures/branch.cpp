// Branches of periodic motions over one key: stable motions as full lines, unstable ones dashed, bifurcations
// marked, over the points of a bifurcation diagram if the folder has one. Motions without impacts show the
// least force of their lasting contacts.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/files/input_file.hpp"
#include "io/scene/schema.hpp"
#include "plots/drawing/column_title.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

/// Titles and looks of the kinds of bifurcations in the figures `branch` and `curves`.
struct BifurcationLook {
  const char* kind;  ///< in bifurcations.csv
  const char* title;
  Word mark;  ///< of a point
  Word line;  ///< of a curve over two keys; empty: there is none
};
constexpr BifurcationLook bifurcation_looks[] = {
    {"fold", "fold", "pt 9 ps 1.0 lc rgb C4", "lw 2 lc rgb C4"},
    {"flip", "period doubling", "pt 7 ps 0.9 lc rgb C5", "lw 2 dt (8,3) lc rgb C5"},
    {"torus", "torus", "pt 5 ps 0.9 lc rgb C6", "lw 2 dt (2,3) lc rgb C6"},
    {"grazing", "grazing impact", "pt 2 ps 1.0 lw 2 lc rgb C7", "lw 2 dt (8,3,2,3) lc rgb C7"},
    {"liftoff", "lift-off", "pt 13 ps 1.1 lc rgb C8", "lw 2.4 lc rgb C8"},
    {"sequence", "other sequence", "pt 11 ps 1.0 lc rgb C9", ""}};

/// Column of the ordinate: that of the bifurcation diagram if it is one of impacts, else the approach speed;
/// without impacts, the least force of the lasting contacts.
std::string ordinate(const std::filesystem::path& folder) {
  if (!Rows(folder / "branch_impacts.csv").next()) return "least_force";
  if (!std::filesystem::exists(folder / "bifurcation.json")) return "approach";
  const JsonFile diagram(folder / "bifurcation.json");
  const auto name = diagram.text("bifurcation.columns.0.name");
  return name == "phase" ? name : "approach";
}

/// Title of the axis of a key, with the stated unit or, of unscaled values, that of the key.
AxisTitle title_of_key(const JsonFile& document, const std::string& at) {
  const auto key = document.text(at + "key");
  auto unit = document.text(at + "unit");
  if (unit.empty() && document.number(at + "scale") == 1) unit = printed(unit_of(key));
  return AxisTitle::plain(key, unit);
}

std::vector<std::filesystem::path> draw_branch(const std::filesystem::path& folder) {
  const JsonFile document(folder / "continue.json");
  const double scale = document.number("continue.scale");
  const auto column = ordinate(folder);
  // Points by branch and motion; a motion with several impacts has several curves.
  const bool forces = column == "least_force";
  Rows rows(folder / (forces ? "branch.csv" : "branch_impacts.csv"));
  if (!rows.has(column)) return {};
  const auto branch = rows.place("branch"), point = rows.place("point"), value = rows.place("parameter"),
             stable = rows.place("stable"), at = rows.place(column);
  struct Motion {
    double x = 0, stable = 0;
    std::vector<double> y;
  };
  std::map<std::pair<int, int>, Motion> motions;
  Limits across, up;
  while (rows.next()) {
    if (std::isnan(rows.number(at))) continue;
    auto& m = motions[{static_cast<int>(rows.number(branch)), static_cast<int>(rows.number(point))}];
    m.x = scale * rows.number(value);
    m.stable = rows.number(stable);
    m.y.push_back(rows.number(at));
    across.hold(m.x);
    up.hold(m.y.back());
  }
  if (motions.empty()) return {};
  Figure f{.name = "branch", .height_cm = 10, .source = "continue.json"};
  Block cloud("brute force: parameter, " + column);
  if (!forces && std::filesystem::exists(folder / "bifurcation.csv")) {
    Rows points(folder / "bifurcation.csv");
    const auto x = points.place("value"), y = points.place(column);
    while (points.next())
      if (std::isfinite(points.number(y))) {
        cloud.row({points.number(x), points.number(y)});
        up.hold(points.number(y));
      }
  }
  const ReadTable events(folder / "bifurcations.csv", {"kind"}, {"parameter", "branch", "point"});
  const auto motion_after = [&](std::size_t event) {
    return std::pair(static_cast<int>(events.column("branch")[event]),
                     static_cast<int>(events.column("point")[event]));
  };
  std::map<std::pair<int, int>, double> located;  // bifurcations by the motion that follows
  for (std::size_t k = 0; k < events.rows(); ++k)
    located[motion_after(k)] = scale * events.column("parameter")[k];
  Block solid("stable: parameter, " + column), dashed("unstable: parameter, " + column);
  // The i-th impact of successive motions is a curve; it ends where the number of impacts, the stability or
  // the circle of phases is passed.
  for (auto m = motions.begin(); m != motions.end(); ++m) {
    const auto next = std::next(m);
    if (next == motions.end() || next->first.first != m->first.first ||
        next->second.y.size() != m->second.y.size())
      continue;
    // Where stability changes, the bifurcation divides the segment.
    double share = 1;
    if (m->second.stable != next->second.stable) {
      const auto at_next = located.find(next->first);
      share = at_next == located.end() || next->second.x == m->second.x
                  ? 0.5
                  : std::clamp((at_next->second - m->second.x) / (next->second.x - m->second.x), 0.0, 1.0);
    }
    for (std::size_t i = 0; i < m->second.y.size(); ++i) {
      // After a move of the section the same impacts begin with another one.
      const double here = m->second.y[i];
      double there = next->second.y[i];
      for (const double y : next->second.y)
        if (std::abs(y - here) < std::abs(there - here)) there = y;
      if (column == "phase" && std::abs(there - here) > 0.5) continue;
      const double x = m->second.x + share * (next->second.x - m->second.x),
                   y = here + share * (there - here);
      (m->second.stable > 0 ? solid : dashed).row({m->second.x, here}).row({x, y}).gap();
      if (share < 1)
        (next->second.stable > 0 ? solid : dashed).row({x, y}).row({next->second.x, there}).gap();
    }
  }
  std::map<std::string, Block> found;
  for (std::size_t k = 0; k < events.rows(); ++k) {
    // The motions beside the bifurcation give its ordinate.
    const double x = scale * events.column("parameter")[k];
    const auto [of, number] = motion_after(k);
    const auto next = motions.find({of, number});
    const auto before = next == motions.end() ? motions.find({of, number - 1}) : std::prev(next);
    if (before == motions.end()) continue;
    const auto& kind = events.text("kind")[k];
    auto& block = found.try_emplace(kind, Block(kind + ": parameter, " + column)).first->second;
    if (forces && kind == "liftoff") {
      block.row({x, 0.0});
      across.hold(x);
      up.hold(0);
      continue;
    }
    for (std::size_t i = 0; i < before->second.y.size(); ++i) {
      double y = before->second.y[i];
      if (next != motions.end() && next->second.y.size() == before->second.y.size() &&
          next->second.x != before->second.x) {
        const double share =
            std::clamp((x - before->second.x) / (next->second.x - before->second.x), 0.0, 1.0);
        y += share * (next->second.y[i] - y);
      }
      block.row({x, y});
    }
  }
  Panel panel{.title = title_of_column(column, column == "phase" ? ""
                                               : forces          ? "N"
                                                                 : "m/s"),
              .axis = axis_of(up.least, up.most),
              .curves = {}};
  if (column == "phase") panel.axis = {0, 1};
  const auto add = [&](const Block& block, const Script& look, const std::string& title) {
    add_curve(f, panel, block, Script().add("using 1:2 with {}", look), title);
  };
  add(solid, Script().add("lines lw 2.2 lc rgb C1"), "stable");
  add(dashed, Script().add("lines lw 1.6 dt (6,4) lc rgb C2"), "unstable");
  add(cloud, Script().add("points pt 7 ps 0.25 lc rgb 0x555555"), "settled motions");
  for (const auto& m : bifurcation_looks)
    if (const auto it = found.find(m.kind); it != found.end())
      add(it->second, Script().add("points {}", m.mark), m.title);
  const double margin = across.range() > 0 ? 0.02 * across.range() : 1;
  return {draw_panels(
      f, folder,
      {.abscissa = {title_of_key(document, "continue."), {across.least - margin, across.most + margin}},
       .panels = {std::move(panel)},
       .each = 7.5})};
}

// Curves of bifurcations over two keys: the first key along the abscissa, the second one along the ordinate.

std::vector<std::filesystem::path> draw_curves(const std::filesystem::path& folder) {
  const JsonFile document(folder / "continue.json");
  const double scale = document.number("continue.scale"),
               second_scale = document.number("continue.second.scale");
  std::array<std::vector<Block>, std::size(bifurcation_looks)> blocks;
  Limits across, up;
  Rows rows(folder / "curves.csv");
  const auto curve = rows.place("curve"), kind = rows.place("kind"), x = rows.place("parameter"),
             y = rows.place("second");
  std::string last;
  while (rows.next()) {
    const auto of =
        std::ranges::find_if(bifurcation_looks, [&](const auto& k) { return rows.name(kind) == k.kind; });
    if (of == std::end(bifurcation_looks)) continue;
    auto& list = blocks[static_cast<std::size_t>(of - bifurcation_looks)];
    if (list.empty()) list.emplace_back(std::string(of->title) + ": first key, second key");
    if (rows.name(curve) != last) list.front().gap();
    last = rows.name(curve);
    const double px = scale * rows.number(x), py = second_scale * rows.number(y);
    list.front().row({px, py});
    across.hold(px);
    up.hold(py);
  }
  if (!(across.range() > 0)) return {};
  Figure f{.name = "curves", .height_cm = 10, .source = "continue.json"};
  Panel panel{
      .title = title_of_key(document, "continue.second."), .axis = axis_of(up.least, up.most), .curves = {}};
  for (std::size_t i = 0; i < blocks.size(); ++i)
    if (!blocks[i].empty())
      add_curve(f, panel, std::move(blocks[i].front()),
                Script().add("using 1:2 with lines {}", bifurcation_looks[i].line),
                bifurcation_looks[i].title);
  const double margin = 0.02 * across.range();
  return {draw_panels(
      f, folder,
      {.abscissa = {title_of_key(document, "continue."), {across.least - margin, across.most + margin}},
       .panels = {std::move(panel)},
       .each = 7.5})};
}

}  // namespace

const Drawing branch{{"continue.json"}, draw_branch};
const Drawing curves{{"curves.csv"}, draw_curves};

}  // namespace freeplay::plots
