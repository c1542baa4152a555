// Points of a Poincaré section in the plane of two columns.
#include <fmt/format.h>

#include <cmath>

#include "io/files/input_file.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

std::string axis(const JsonFile& document, const std::string& which) {
  const auto unit = document.text("section." + which + "_unit");
  return document.text("section." + which) + (unit.empty() ? "" : " (" + unit + ")");
}

std::vector<std::filesystem::path> draw_poincare(const std::filesystem::path& folder) {
  const JsonFile document(folder / "section.json");
  const auto x = document.text("section.x"), y = document.text("section.y");
  Rows rows(folder / "section.csv");
  const auto at_x = rows.place(x), at_y = rows.place(y);
  Block points(x + ", " + y);
  while (rows.next()) {
    const double a = rows.number(at_x), b = rows.number(at_y);
    if (std::isfinite(a) && std::isfinite(b)) points.row({a, b});
  }
  const bool none = points.empty();
  Figure f{.name = "poincare", .width_cm = 12, .height_cm = 10, .source = "section.json"};
  f.blocks.push_back(points);
  f.script.add(
      "set xlabel {} noenhanced\nset ylabel {} noenhanced\nset offsets graph 0.05, graph 0.05, graph 0.05, graph 0.05\n",
      axis(document, "x"), axis(document, "y"));
  if (none)
    f.script.add(
        "set label 1 'no point of the section' at graph 0.5, graph 0.5 center tc rgb 0x888888\n"
        "set xrange [0:1]\nset yrange [0:1]\nset format ''\nplot NaN notitle\n");
  else
    f.script.add("plot DATA index 0 using 1:2 with points pt 7 ps 0.35 lc rgb C1 notitle\n");
  return {draw(f, folder)};
}

}  // namespace

const Drawing poincare{{"section.json"}, draw_poincare};

}  // namespace freeplay::plots
