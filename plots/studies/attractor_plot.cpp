// Chosen columns of a bifurcation diagram over its parameter, and of a basin over its grid.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/files/input_file.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/column_title.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/heat_map.hpp"
#include "plots/figures/attractors.hpp"
#include "plots/studies/study_plot.hpp"
#include "plots/studies/sweep_runs.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

struct SectionColumn {
  std::string name, unit;
};

/// Columns of the section of a bifurcation or basin, and the period of its attractors.
std::vector<SectionColumn> columns_of_attractors(const JsonFile& document, const std::string& kind) {
  std::vector<SectionColumn> list;
  const auto* columns = document.find(kind + ".columns");
  for (std::size_t i = 0; columns && i < columns->size(); ++i) {
    const auto path = fmt::format("{}.columns.{}.", kind, i);
    list.push_back({document.text(path + "name"), document.text_or_empty(path + "unit")});
  }
  list.push_back({"period", ""});
  if (document.find(kind + ".exponent_periods")) list.push_back({"exponent", "1/s"});
  return list;
}

SectionColumn known_column(const std::vector<SectionColumn>& all, const std::string& name) {
  const auto it = std::ranges::find(all, name, &SectionColumn::name);
  if (it != all.end()) return *it;
  std::vector<std::string> names;
  for (const auto& c : all) names.push_back(c.name);
  throw SceneError("--y: " + unknown_name("column", name, {{"columns", names}}));
}

void refuse_axes(const StudyPlot& plot, const char* what) {
  if (!plot.x.empty()) throw SceneError(fmt::format("--x: the axes of {} are those of its study", what));
}

AxisTitle axis_of_document(const JsonFile& document, const std::string& path) {
  return AxisTitle::plain(document.text(path + ".name"), document.text_or_empty(path + ".unit"));
}

}  // namespace

std::filesystem::path draw_bifurcation_of(const StudyPlot& plot) {
  refuse_axes(plot, "a bifurcation diagram");
  if (plot.y.size() != 1)
    throw SceneError("--y: a bifurcation diagram shows one column; draw several figures");
  const JsonFile document(plot.folder / "bifurcation.json");
  const auto column = known_column(columns_of_attractors(document, "bifurcation"), plot.y.front());
  Figure f{.name = name_of_plot(plot, "bifurcation"),
           .height_cm = 10,
           .source = "bifurcation.json",
           .formats = plot.formats};
  if (!add_bifurcation(f, plot.folder, column.name, column.unit))
    throw SceneError(plot.folder.string() + ": contains no run of a bifurcation diagram");
  return draw(f, plot.folder);
}

std::filesystem::path draw_basin_of(const StudyPlot& plot) {
  refuse_axes(plot, "a basin");
  const JsonFile document(plot.folder / "basin.json");
  const auto all = columns_of_attractors(document, "basin");
  HeatMap map{.x = axis_of_document(document, "basin.x"),
              .y = axis_of_document(document, "basin.y"),
              .grid = true,
              .heading = "x, y, value at the last section point",
              .panels = {}};
  for (const auto& name : plot.y) {
    const auto column = known_column(all, name);
    const ReadTable table(plot.folder / "basin.csv", {}, {"x", "y", column.name});
    auto& panel = map.panels.emplace_back(HeatPanel{
        "", name_with_unit(column.name, column.unit), title_of_column(column.name, column.unit), {}});
    for (std::size_t i = 0; i < table.rows(); ++i)
      panel.cells.push_back({table.column("x")[i], table.column("y")[i], table.column(column.name)[i]});
  }
  Figure f{.name = name_of_plot(plot, "basin"), .source = "basin.json", .formats = plot.formats};
  f.caption = fmt::format("{} of the attractor reached from each start.", fmt::join(plot.y, ", "));
  if (map.panels.size() == 1) f.width_cm = 13;
  add_heat_map(f, map, style_of(plot.folder));
  return draw(f, plot.folder);
}

}  // namespace freeplay::plots
