#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "io/files/input_file.hpp"
#include "plots/drawing/curve_look.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {

// The measured mean turn, with those of both formulations over it.

namespace {

std::vector<std::filesystem::path> draw_overlay(const std::filesystem::path& folder) {
  const std::vector<std::string> curves{"measured", "penalty", "nonsmooth"};
  const ReadTable table(folder / "overlay.csv", {}, {"crank_angle", "measured", "penalty", "nonsmooth"});
  if (table.rows() == 0) return {};
  const auto& angle = table.column("crank_angle");
  Figure f{.name = "overlay", .source = "validation.json"};
  for (const auto& name : curves) {
    auto& block = f.blocks.emplace_back(fmt::format("crank angle (deg), {} (m/s^2)", name));
    for (std::size_t i = 0; i < table.rows(); ++i) block.row({angle[i], table.column(name)[i]});
  }
  Limits up;
  for (const auto& name : curves)
    for (const double a : table.column(name)) up.hold(a);
  f.caption = "Mean turn of the acceleration.";
  Panel panel{.title = AxisTitle::of({"acceleration a", "acceleration $a$"}, "m/s²"),
              .axis = axis_of(up.least, up.most),
              .curves = {{Script().add("DATA index 0 using 1:2 with lines lc rgb 0x888888 lw 4"), "measured"},
                         {Script().add("DATA index 1 using 1:2 with lines ls 1"), "penalty"},
                         {Script().add("DATA index 2 using 1:2 with lines ls 2"), "nonsmooth"}}};
  return {draw_panels(f, folder,
                      {.abscissa = {crank_title(), {.low = 0, .high = 360, .turn = true}},
                       .panels = {std::move(panel)},
                       .each = 6.5})};
}

// Measured points of a study with their uncertainty, and the values of each variant there, over the
// first axis: a panel for each quantity. Lines are nonsmooth, dashes penalty.

std::vector<std::filesystem::path> draw_points(const std::filesystem::path& folder) {
  const JsonFile document(folder / "points.json");
  if (document.find("axes.1")) return {};  // a curve over one axis is drawn only
  const auto axis = document.text("axes.0.name"), unit = document.text("axes.0.unit");
  struct Curve {
    std::string variant, formulation;
    std::map<double, double> points;
  };
  struct Panel {
    std::string quantity;
    std::map<double, std::array<double, 2>> measured;
    std::vector<Curve> curves;
  };
  std::vector<Panel> panels;
  const auto panel_of = [&](const std::string& quantity) -> Panel& {
    const auto found = std::ranges::find(panels, quantity, &Panel::quantity);
    return found != panels.end() ? *found : *panels.insert(panels.end(), {quantity, {}, {}});
  };
  const ReadTable points(folder / "points.csv", {"quantity"}, {axis, "measured", "uncertainty"});
  for (std::size_t i = 0; i < points.rows(); ++i)
    panel_of(points.text("quantity")[i]).measured[points.column(axis)[i]] = {
        points.column("measured")[i], 2 * points.column("uncertainty")[i]};
  const ReadTable runs(folder / "curves.csv", {"quantity", "variant", "formulation"}, {axis, "model"});
  std::vector<std::string> variants;
  for (std::size_t i = 0; i < runs.rows(); ++i) {
    const auto &variant = runs.text("variant")[i], &formulation = runs.text("formulation")[i];
    auto& curves = panel_of(runs.text("quantity")[i]).curves;
    place_in(variants, variant);
    auto curve = std::ranges::find_if(
        curves, [&](const Curve& c) { return c.variant == variant && c.formulation == formulation; });
    if (curve == curves.end()) curve = curves.insert(curves.end(), {variant, formulation, {}});
    curve->points[runs.column(axis)[i]] = runs.column("model")[i];
  }
  if (panels.empty()) return {};
  Figure f{.name = "points", .source = "points.json"};
  const double rows = std::ceil(static_cast<double>(panels[0].curves.size() + 1) / 3);
  f.height_cm = 1.2 + 6.2 * static_cast<double>(panels.size()) + 0.5 * rows;
  f.script.add("set multiplot layout {},1 margins X(2.0),1-X(0.4),Y(1.4),1-Y({}) spacing 0,Y(1.4)\n",
               panels.size(), 0.5 + 0.5 * rows);
  f.script.add(
      "set xlabel {} noenhanced\nset key at graph 0.5, graph 1.02 center bottom horizontal maxcols 3 "
      "samplen 3 font SMALL\n",
      axis + (unit.empty() ? "" : " (" + unit + ")"));
  std::size_t block = 0;
  for (const auto& panel : panels) {
    f.blocks.emplace_back(panel.quantity + ", measured: " + axis + ", value, two standard uncertainties");
    for (const auto& [at, one] : panel.measured) f.blocks.back().row({at, one[0], one[1]});
    f.script.add(
        "set ylabel {} noenhanced\nplot DATA index {} using 1:2:3 with yerrorbars pt 7 ps 1 lc rgb "
        "'black' title {}",
        panel.quantity, block++, Word("'measured'"));
    for (const auto& curve : panel.curves) {
      f.blocks.emplace_back(fmt::format("{}, {} [{}]", panel.quantity, curve.variant, curve.formulation));
      for (const auto& [at, one] : curve.points)
        if (std::isfinite(one)) f.blocks.back().row({at, one});
      const auto look =
          curve_look(static_cast<std::size_t>(std::ranges::find(variants, curve.variant) - variants.begin()),
                     curve.formulation == "penalty");
      f.script.add(", '' index {} using 1:2 with lines lw 1.5 dt {} lc rgb C{} title {}", block++, look.dash,
                   look.colour, curve.variant + " [" + curve.formulation + "]");
    }
    f.script.add("\nunset key\n");
  }
  f.script.add("unset multiplot\n");
  return {draw(f, folder)};
}

}  // namespace

const Drawing overlay{{"validation.json"}, draw_overlay};
const Drawing points{{"points.json"}, draw_points};

}  // namespace freeplay::plots
