// Wear of bearings: depth over turns with its error, and the worn surfaces over the angle.
//
// wear_depth_* shows the greatest depth of each surface of a joint, with ± 1.96 standard errors and the
// extrapolation error. wear_profile_* shows a surface in polar form, its nominal radius R as a circle and the
// depth h magnified by a round factor M,
//
//     r(φ) = R ± M h(φ)      (+: bearing, −: journal),
//
// after some cycles: about a quarter, half and three quarters of the greatest depth, and the last one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "io/files/input_file.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

constexpr double band_errors = 1.96;  // standard errors of a 95 % interval
constexpr Word surface_names[] = {"bearing", "journal"};

/// One joint by one formulation: a row for each cycle.
struct WearCurve {
  std::string formulation, joint;
  std::vector<double> turns, cycle;
  std::vector<double> depth[2], error[2];  // m, of bearing and journal
  bool worn(std::size_t side) const { return Limits(depth[side]).most > 0; }
  /// 1, 2: line style
  int style() const { return formulation == "penalty" ? 1 : 2; }
};

std::vector<WearCurve> curves_in(const std::filesystem::path& folder) {
  const ReadTable table(
      folder / "wear.csv", {"formulation", "joint"},
      {"cycle", "turns", "bearing_depth", "bearing_depth_statistical", "bearing_depth_extrapolation",
       "journal_depth", "journal_depth_statistical", "journal_depth_extrapolation"});
  std::vector<WearCurve> list;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const auto &formulation = table.text("formulation")[i], &joint = table.text("joint")[i];
    if (list.empty() || list.back().formulation != formulation || list.back().joint != joint)
      list.push_back(
          {.formulation = formulation, .joint = joint, .turns = {}, .cycle = {}, .depth = {}, .error = {}});
    auto& c = list.back();
    c.turns.push_back(table.column("turns")[i]);
    c.cycle.push_back(table.column("cycle")[i]);
    for (std::size_t side = 0; side < 2; ++side) {
      const auto of = [&](const char* what) {
        return table.column(fmt::format("{}_depth{}", surface_names[side].text(), what))[i];
      };
      c.depth[side].push_back(of(""));
      c.error[side].push_back(band_errors * of("_statistical") + of("_extrapolation"));
    }
  }
  return list;
}

std::filesystem::path draw_depths(const std::filesystem::path& folder, const std::string& joint,
                                  const std::vector<WearCurve>& curves) {
  Figure f{.name = file_name("wear_depth", joint), .source = "wear.json"};
  f.caption = fmt::format(
      "Greatest depth of wear in {} over turns, ± 1.96 standard errors and the extrapolation error.", joint);
  f.script.add("set style fill transparent solid 0.25 noborder\n");
  PanelStack stack{.abscissa = {AxisTitle::of("turns", ""), {}}, .panels = {}, .each = 4.5};
  Limits turns;
  for (const auto& c : curves)
    for (const double t : c.turns) turns.hold(t);
  const auto unit_of_turns = fitting_unit("", turns.most);
  for (std::size_t side = 0; side < 2; ++side) {
    Limits values;
    values.hold(0);
    for (const auto& c : curves)
      for (std::size_t i = 0; i < c.turns.size(); ++i) values.hold(c.depth[side][i] + c.error[side][i]);
    if (!(values.most > 0)) continue;
    const auto unit = fitting_unit("m", values.most);
    Panel panel{.title = AxisTitle::of(fmt::format("depth of the {}", surface_names[side].text()),
                                       Script().add("'h'"), 1, unit.name),
                .axis = axis_of(0, values.most / unit.size),
                .curves = {}};
    for (const auto& c : curves) {
      if (!c.worn(side)) continue;
      Block block(fmt::format("{}, {}: turns ({}), depth, lower and upper limit ({})", c.formulation, joint,
                              unit_of_turns.name, unit.name));
      for (std::size_t i = 0; i < c.turns.size(); ++i) {
        const double h = c.depth[side][i], e = c.error[side][i];
        block.row({c.turns[i] / unit_of_turns.size, h / unit.size, std::max(0.0, h - e) / unit.size,
                   (h + e) / unit.size});
      }
      panel.curves.push_back({Script().add("DATA index {} using 1:3:4 with filledcurves lc rgb {}",
                                           f.blocks.size(), c.style() == 1 ? Word("C1") : Word("C2")),
                              ""});
      add_curve(f, panel, std::move(block),
                Script().add("using 1:2 with linespoints ls {} pt 7 ps 0.4", c.style()), c.formulation);
    }
    stack.panels.push_back(std::move(panel));
  }
  stack.abscissa.title = AxisTitle::of("turns", unit_of_turns.name);
  stack.abscissa.axis = {0, std::max(turns.most, 1e-12) / unit_of_turns.size};
  return draw_panels(f, folder, std::move(stack));
}

/// Cycles to show: those after which the depth first reaches these shares of the last one.
std::vector<double> chosen_cycles(const WearCurve& curve, std::size_t side) {
  std::vector<double> list;
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {
    std::size_t i = 0;
    while (i + 1 < curve.cycle.size() && curve.depth[side][i] < share * curve.depth[side].back()) ++i;
    if (list.empty() || list.back() != curve.cycle[i]) list.push_back(curve.cycle[i]);
  }
  return list;
}

std::filesystem::path draw_profile(const std::filesystem::path& folder, const std::string& joint,
                                   const std::vector<WearCurve>& curves, std::size_t side, double radius) {
  double most = 0;
  for (const auto& c : curves) most = std::max(most, Limits(c.depth[side]).most);
  const double factor = round_factor(0.3 * radius / most), sign = side == 0 ? 1 : -1;
  const auto unit = fitting_unit("m", radius);
  Figure f{.name = file_name(fmt::format("wear_profile_{}", surface_names[side].text()), joint),
           .source = "wear.json"};
  f.caption = fmt::format("Worn {} of {}, depth magnified {:.0f} times; thin: after earlier cycles.",
                          surface_names[side].text(), joint, factor);
  f.width_cm = 12;
  Panel panel{.title = AxisTitle::of("y", unit.name), .axis = {}, .curves = {}};
  Block circle("nominal circle: x, y");
  for (int k = 0; k <= 360; ++k) {
    const double angle = std::numbers::pi / 180 * k;
    circle.row({radius / unit.size * std::cos(angle), radius / unit.size * std::sin(angle)});
  }
  add_curve(f, panel, std::move(circle), Script().add("using 1:2 with lines ls 4"), "nominal");
  const ReadTable table(folder / "profiles.csv", {"formulation", "joint"},
                        {"cycle", "turns", "angle", fmt::format("{}_depth", surface_names[side].text())});
  const auto& depth = table.column(fmt::format("{}_depth", surface_names[side].text()));
  for (const auto& c : curves) {
    if (!c.worn(side)) continue;
    for (const double cycle : chosen_cycles(c, side)) {
      const bool last = cycle == c.cycle.back();
      Block block(fmt::format("{}, cycle {:.0f}: x, y", c.formulation, cycle));
      std::vector<double> first;
      for (std::size_t i = 0; i < table.rows(); ++i) {
        if (table.text("formulation")[i] != c.formulation || table.text("joint")[i] != joint ||
            table.column("cycle")[i] != cycle)
          continue;
        const double r = (radius + sign * factor * depth[i]) / unit.size, angle = table.column("angle")[i];
        const std::vector<double> row{r * std::cos(angle), r * std::sin(angle)};
        if (first.empty()) first = row;
        block.row(row);
      }
      if (!first.empty()) block.row(first);
      add_curve(f, panel, std::move(block),
                Script().add("using 1:2 with lines ls {} lw {}", c.style(), last ? Word("1.8") : Word("0.6")),
                last ? fmt::format("{} × {:.0f}", c.formulation, factor) : "");
    }
  }
  const double wide = 1.05 * (side == 0 ? radius + factor * most : radius) / unit.size;
  panel.axis = {-wide, wide};
  return draw_panels(f, folder,
                     {.abscissa = {AxisTitle::of("x", unit.name), {-wide, wide}},
                      .panels = {std::move(panel)},
                      .equal_scales = true});
}

std::vector<std::filesystem::path> draw_wear(const std::filesystem::path& folder) {
  const JsonFile facts(folder / "wear.json");
  const auto all = curves_in(folder);
  std::vector<std::string> joints;
  for (const auto& c : all) place_in(joints, c.joint);
  std::vector<std::filesystem::path> made;
  const auto* results = facts.find("wear.results");
  if (!results || !results->is_array()) facts.fail("wear.results", "must be a list");
  for (const auto& joint : joints) {
    std::vector<WearCurve> own;
    for (const auto& c : all)
      if (c.joint == joint && (c.worn(0) || c.worn(1))) own.push_back(c);
    if (own.empty()) continue;
    made.push_back(draw_depths(folder, joint, own));
    double radius = 0, clearance = 0;
    for (std::size_t i = 0; i < results->size(); ++i) {
      const auto at = fmt::format("wear.results.{}.", i);
      if (facts.text(at + "joint") != joint) continue;
      radius = facts.number(at + "bearing_radius_m");
      clearance = facts.number(at + "nominal_clearance_m");
    }
    if (!(radius > clearance) || !(clearance > 0))
      facts.fail("wear.results", "must have the radii of each joint");
    for (std::size_t side = 0; side < 2; ++side)
      if (std::ranges::any_of(own, [&](const WearCurve& c) { return c.worn(side); }))
        made.push_back(draw_profile(folder, joint, own, side, side == 0 ? radius : radius - clearance));
  }
  return made;
}

}  // namespace

const Drawing wear{{"wear.json"}, draw_wear};

}  // namespace freeplay::plots
