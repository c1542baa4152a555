// Phase portraits of the bodies of a run after its transient: the rate of a coordinate over this coordinate
// (plots/figures/phase_portrait.hpp), without bodies that only rotate steadily; and Poincaré sections.

#include "plots/figures/phase_portrait.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/files/input_file.hpp"
#include "plots/drawing/column_title.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/run_facts.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {

int phase_coordinate(const std::array<std::vector<double>, 6>& m) {
  const auto moves = [&](std::size_t k) {
    const auto [least, most] = std::ranges::minmax(m[k]);
    return most - least > 1e-6 * std::max({std::abs(least), std::abs(most), 1e-6});
  };
  if (range_of(m[2]) < 2 * std::numbers::pi && moves(2) && moves(5)) return 2;
  const std::size_t k = range_of(m[3]) >= range_of(m[4]) ? 0 : 1;
  return moves(k) && moves(3 + k) ? static_cast<int>(k) : -1;
}

PhasePlane phase_plane(const std::array<std::vector<double>, 6>& motion, std::size_t k) {
  const AxisTitle places[] = {AxisTitle::of({"x", "$x$"}, "m"), AxisTitle::of({"y", "$y$"}, "m"),
                              AxisTitle::of({"θ", "$\\theta$"}, "rad")};
  const AxisTitle rates[] = {AxisTitle::of({"v_x", "$v_x$"}, "m/s"), AxisTitle::of({"v_y", "$v_y$"}, "m/s"),
                             AxisTitle::of({"ω", "$\\omega$"}, "rad/s")};
  PhasePlane plane{fitting_unit(places[k].unit, Limits(motion[k]).size()),
                   fitting_unit(rates[k].unit, Limits(motion[3 + k]).size()), places[k], rates[k]};
  plane.place.unit = plane.place_unit.name, plane.rate.unit = plane.rate_unit.name;
  return plane;
}

namespace {

constexpr std::size_t bodies_drawn = 9, across = 3;
constexpr long rows_drawn = 20'000;
constexpr double least_cell = 3;  ///< cm at the usual text size, for portraits side by side

std::vector<std::filesystem::path> draw_phase_portrait(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / "comparison.json") || runs_in(folder).empty()) return {};
  const double end = end_of(folder), discard = discard_of(folder);
  const Span span{discard < end ? discard : 0, end, ""};
  const auto motion = motion_of(folder, span, bodies_drawn, rows_drawn);
  if (motion.t.size() < 3) return {};
  struct Panel {
    std::size_t body, coordinate;
  };
  std::vector<Panel> panels;
  for (std::size_t b = 0; b < motion.bodies.size(); ++b)
    if (const int k = phase_coordinate(motion.coordinates[b]); k >= 0)
      panels.push_back({b, static_cast<std::size_t>(k)});
  if (panels.empty()) return {};

  const auto style = style_of(folder);
  const double scale = style.font_size / Style::usual_font_size;
  // cm at the usual text size; a single portrait needs less
  const double width = (style.width ? 0.1 * *style.width : panels.size() == 1 ? 9.0 : 16.0) / scale;
  const auto cell_of = [&](std::size_t columns) {
    const auto n = static_cast<double>(columns);
    return (width - 1.75 - 0.35 - (n - 1) * 2.05) / n;
  };
  auto columns = std::min(across, panels.size());
  while (columns > 1 && cell_of(columns) < least_cell) --columns;
  const auto rows = (panels.size() + columns - 1) / columns;
  Figure f{.name = "phase_portrait", .width_cm = width * scale, .source = "run.json"};
  f.caption = fmt::format("Phase portraits, {:.4g} to {:.4g} s.", span.from, span.to);
  const auto lines = static_cast<double>(rows);
  const double cell = cell_of(columns),
               square = std::min(std::max(cell, 1.6), columns > 1 || rows == 1 ? 5.0 : 3.2);
  f.width_cm = width_of(f, style);
  f.height_cm =
      style.height ? 0.1 * *style.height : scale * (0.55 + 1.2 + lines * square + (lines - 1) * 1.75);
  f.sized = true;
  f.script.add(
      "set multiplot layout {},{} margins X(1.75),1-X(0.35),Y(1.2),1-Y(0.55) spacing "
      "X(2.05),Y(1.75)\nunset key\nset title offset 0,-0.7\n",
      rows, columns);
  for (std::size_t p = 0; p < panels.size(); ++p) {
    const auto& [body, k] = panels[p];
    const auto &q = motion.coordinates[body][k], &v = motion.coordinates[body][3 + k];
    const auto plane = phase_plane(motion.coordinates[body], k);
    const auto &x_unit = plane.place_unit, &y_unit = plane.rate_unit;
    Block block(fmt::format("{}: {} ({}), rate ({})", motion.bodies[body],
                            k == 2   ? "theta"
                            : k == 1 ? "y"
                                     : "x",
                            x_unit.name, y_unit.name));
    for (std::size_t i = 0; i < q.size(); ++i) block.row({q[i] / x_unit.size, v[i] / y_unit.size});
    const auto [least, most] = std::ranges::minmax(q);
    const auto [slowest, fastest] = std::ranges::minmax(v);
    const double margin = 0.05 * (most - least) / x_unit.size;
    const Axis x{least / x_unit.size - margin, most / x_unit.size + margin};
    f.script.add(
        "{}{}set title {} noenhanced\nset xlabel {}\nset ylabel {}\nplot DATA index {} using 1:2 with "
        "lines lw 0.8 lc rgb C{}\n",
        commands(with_tics(x, 6, cell / letter_width), "x"),
        commands(
            with_tics(axis_of(slowest / y_unit.size, fastest / y_unit.size), square / (1.45 * line_height)),
            "y"),
        shortened(motion.bodies[body], static_cast<std::size_t>(cell / letter_width) + 6),
        plane.place.label(99), plane.rate.label(99), p, 1 + body);
    f.blocks.push_back(std::move(block));
  }
  f.script.add("unset multiplot\n");
  return {draw(f, folder)};
}

// Points of a Poincaré section in the plane of two columns.

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
  return {draw_panels(f, folder, std::move(stack))};
}

}  // namespace

const Drawing phase_portrait{{"run.json"}, draw_phase_portrait};
const Drawing poincare{{"section.json"}, draw_poincare};

}  // namespace freeplay::plots
