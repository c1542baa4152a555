// Points of a Poincaré section in the plane of two columns.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/files/input_file.hpp"
#include "plots/drawing/column_title.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

/// One axis of the section, in a fitting unit.
struct SectionAxis {
  ShownUnit unit;
  Abscissa shown;
};

SectionAxis section_axis(const std::string& column, const std::string& si,
                         const std::vector<double>& values) {
  Limits range(values);
  constexpr double rounding = 1e-12;  // SI; smaller values of all columns are rounding errors
  if (values.empty() || range.size() < rounding) range.least = range.most = 0;
  const auto unit = fitting_unit(si, range.size());
  return {unit,
          {title_of_column(column, unit.name), axis_of(range.least / unit.size, range.most / unit.size)}};
}

std::vector<std::filesystem::path> draw_poincare(const std::filesystem::path& folder) {
  const JsonFile document(folder / "section.json");
  const auto x = document.text("section.x"), y = document.text("section.y");
  Rows rows(folder / "section.csv");
  const auto at_x = rows.place(x), at_y = rows.place(y);
  Points points;
  while (rows.next()) {
    const double a = rows.number(at_x), b = rows.number(at_y);
    if (!std::isfinite(a) || !std::isfinite(b)) continue;
    points.x.push_back(a);
    points.y.push_back(b);
  }
  const auto across = section_axis(x, document.text("section.x_unit"), points.x),
             up = section_axis(y, document.text("section.y_unit"), points.y);
  Block block(fmt::format("{} ({}), {} ({})", x, across.unit.name, y, up.unit.name));
  for (std::size_t i = 0; i < points.x.size(); ++i)
    block.row({points.x[i] / across.unit.size, points.y[i] / up.unit.size});
  Figure f{.name = "poincare", .width_cm = 12, .source = "section.json"};
  if (points.x.empty())
    f.script.add(
        "set label 2 'no point of the section' at graph 0.5, graph 0.5 center tc rgb 0x888888\n"
        "set xrange [0:1]\nset yrange [0:1]\nset format ''\n");
  PanelStack stack{.abscissa = across.shown,
                   .panels = {{.title = up.shown.title,
                               .axis = up.shown.axis,
                               .curves = {{Script().add("DATA index 0 using 1:2 with points pt 7 ps {} "
                                                        "lc rgb C1",
                                                        points.x.size() < 50 ? 0.8 : 0.35),
                                           ""}}}},
                   .each = 8.4};
  f.blocks.push_back(std::move(block));
  add_panels(f, style_of(folder), std::move(stack));
  return {draw(f, folder)};
}

}  // namespace

const Drawing poincare{{"section.json"}, draw_poincare};

}  // namespace freeplay::plots
