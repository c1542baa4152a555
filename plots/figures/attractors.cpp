// Bifurcation diagram: section points over a parameter, one colour per branch. Basins of
// attraction: the attractor reached from each start of a grid.

#include "plots/figures/attractors.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "io/files/input_file.hpp"
#include "plots/drawing/column_title.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/drawing/style.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

AxisTitle axis_title(const JsonFile& document, const std::string& path) {
  return AxisTitle::plain(document.text(path + ".name"), document.text(path + ".unit"));
}

/// Upward branch: dots of the first colour, drawn over the rings of the second colour of the
/// downward branch, so that neither hides the other. Points from random starts are grey and below
/// both.
constexpr Word branch_colours[] = {"0x9aa0a6", "C1", "C2"};
constexpr Word branch_marks[] = {"7", "7", "6"};
constexpr Word no_points =
    "set label 1 'no point of the section' at graph 0.5, graph 0.5 center tc rgb 0x888888\n";
int place_of(const std::string& branch) { return branch == "up" ? 1 : branch == "down" ? 2 : 0; }

std::vector<std::filesystem::path> draw_bifurcation(const std::filesystem::path& folder) {
  const JsonFile document(folder / "bifurcation.json");
  Figure f{.name = "bifurcation", .source = "bifurcation.json"};
  if (!add_bifurcation(f, folder, document.text("bifurcation.columns.0.name"),
                       document.text("bifurcation.columns.0.unit"), true))
    return {};
  return {draw(f, folder)};
}

/// The largest Lyapunov exponent of a run's attractor (1/s).
struct ShownExponent {
  int branch = 0;
  double x = 0, value = 0, error = 0;
};

/// Exponents over the parameter, in the colours of their branches, with two standard errors.
Panel exponent_panel(Figure& f, const std::vector<ShownExponent>& exponents) {
  Block vanished("value whose exponent is minus infinity, height");
  Block known[] = {Block("random starts: value, exponent (1/s), two standard errors"),
                   Block("swept upwards: value, exponent (1/s), two standard errors"),
                   Block("swept downwards: value, exponent (1/s), two standard errors")};
  Limits up;
  up.hold(0);
  for (const auto& e : exponents) {
    if (std::isnan(e.value)) continue;
    if (std::isfinite(e.value))
      known[e.branch].row({e.x, e.value, 2 * e.error});
    else
      vanished.row({e.x, 0.03});
    up.hold(e.value - 2 * e.error);
    up.hold(e.value + 2 * e.error);
  }
  Panel panel{.title = AxisTitle::plain("Exponent", "1/s"), .axis = axis_of(up.least, up.most), .curves = {}};
  panel.before.add(
      "set y2range [0:1]\nset arrow 1 from graph 0, first 0 to graph 1, first 0 nohead lc rgb 0x888888 dt "
      "3\n");
  for (const std::size_t k : {0u, 2u, 1u}) {
    add_curve(f, panel, known[k],
              Script().add("using 1:2:3 with yerrorbars pt {} ps {} lw 0.8 lc rgb {}", branch_marks[k],
                           k == 2 ? 0.6 : 0.3, branch_colours[k]));
  }
  add_curve(f, panel, vanished, Script().add("using 1:2 axes x1y2 with points pt 11 ps 0.5 lc rgb 0x888888"),
            "minus infinity (at the bottom)");
  return panel;
}

}  // namespace

bool add_bifurcation(Figure& f, const std::filesystem::path& folder, const std::string& column,
                     const std::string& unit, bool with_exponents) {
  const JsonFile document(folder / "bifurcation.json");
  Rows rows(folder / "bifurcation.csv");
  const auto branch = rows.place("branch"), value = rows.place("value"), at = rows.place(column);
  Block blocks[] = {Block("random starts"), Block("swept upwards"), Block("swept downwards")};
  Block none[] = {Block("random starts, no points"), Block("swept upwards, no points"),
                  Block("swept downwards, no points")};
  Limits across, up;  // across: of all values, including those without points
  with_exponents = with_exponents && rows.has("exponent");
  const auto exponent = with_exponents ? rows.place("exponent") : 0,
             error = with_exponents ? rows.place("exponent_error") : 0;
  std::vector<ShownExponent> exponents;
  std::string last;  // run of the last row
  while (rows.next()) {
    const double x = rows.number(value), y = rows.number(at);
    if (with_exponents)
      if (auto run = fmt::format("{} {}", rows.name(branch), x); run != last) {
        exponents.push_back({place_of(rows.name(branch)), x, rows.number(exponent), rows.number(error)});
        last = std::move(run);
      }
    across.hold(x);
    if (std::isfinite(x)) up.hold(y);
    const auto k = static_cast<std::size_t>(place_of(rows.name(branch)));
    if (std::isfinite(x) && std::isfinite(y))
      blocks[k].row({x, y});
    else if (std::isfinite(x))
      none[k].row({x, 0.012 + 0.016 * static_cast<double>(k)});
  }
  constexpr const char* titles[] = {"random starts", "swept upwards", "swept downwards"};
  Panel panel{.title = title_of_column(column, unit), .axis = axis_of(up.least, up.most), .curves = {}};
  if (column == "phase") panel.axis = {0, 1};
  bool points = false, without = false;
  for (const std::size_t k : {0u, 2u, 1u}) {
    if (blocks[k].empty()) continue;
    add_curve(f, panel, blocks[k],
              Script().add("using 1:2 with points pt {} ps {} lw 0.6 lc rgb {}", branch_marks[k],
                           k == 2 ? 0.6 : 0.3, branch_colours[k]));
    panel.curves.push_back(
        {Script().add("keyentry with points pt {} ps 0.8 lc rgb {}", branch_marks[k], branch_colours[k]),
         titles[k]});
    points = true;
  }
  // Runs without section points are marked along the bottom, to distinguish them from values
  // without runs.
  for (std::size_t k = 0; k < 3; ++k) {
    if (none[k].empty()) continue;
    add_curve(f, panel, none[k],
              Script().add("using 1:2 axes x1y2 with points pt 5 ps 0.3 lc rgb {}", branch_colours[k]));
    without = true;
  }
  if (f.blocks.empty()) return false;
  if (without)
    panel.curves.push_back(
        {Script().add("keyentry with points pt 5 ps 0.6 lc rgb 0x888888"), "no points (at the bottom)"});
  panel.before.add("set y2range [0:1]\n");
  if (!points) panel.before.add("{}set format y ''\n", no_points);
  const double margin = across.range() > 0 ? 0.01 * across.range() : 1;
  std::vector<Panel> panels{std::move(panel)};
  double each = 7.5;
  if (with_exponents) {
    panels.push_back(exponent_panel(f, exponents));
    each = 5.5;
  }
  add_panels(
      f, style_of(folder),
      {.abscissa = {axis_title(document, "bifurcation.axis"), {across.least - margin, across.most + margin}},
       .panels = std::move(panels),
       .each = each});
  return true;
}

namespace {

constexpr unsigned basin_colours[] = {0x0b3c8c, 0xe0a458, 0x1a7f37, 0xcf222e, 0x7b3fa0, 0x3d9be0, 0x8a6d3b};
constexpr unsigned greys[] = {0x303030, 0xd8d8d8, 0x787878, 0xa8a8a8, 0x505050, 0xc0c0c0, 0x909090};
constexpr unsigned gave_up = 0xf0f0f0;

/// Colour of an attractor: from the style if it sets colours, grey if it is monochrome, else the
/// default.
unsigned colour_of(const Style& style, int attractor) {
  if (attractor < 0) return gave_up;
  const auto k = static_cast<std::size_t>(attractor);
  if (style.monochrome) return greys[k % std::size(greys)];
  if (style.colours != Style{}.colours) return style.colours[k % style.colours.size()];
  return basin_colours[k % std::size(basin_colours)];
}

/// Half the least distance of two values: half the width of a cell.
double half_step(std::vector<double> values) {
  std::ranges::sort(values);
  double least = INFINITY;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (values[i] > values[i - 1]) least = std::min(least, values[i] - values[i - 1]);
  return std::isfinite(least) ? 0.5 * least : 0.5;
}

std::vector<std::filesystem::path> draw_basin(const std::filesystem::path& folder) {
  const JsonFile document(folder / "basin.json");
  const ReadTable table(folder / "basin.csv", {}, {"x", "y", "attractor"});
  const auto &x = table.column("x"), &y = table.column("y"), &attractor = table.column("attractor");
  if (table.rows() == 0) return {};
  std::map<int, double> exponents;  // of the attractors
  if (Rows rows(folder / "basin.csv"); rows.has("exponent"))
    for (const auto number = rows.place("attractor"), value = rows.place("exponent"); rows.next();)
      exponents.try_emplace(static_cast<int>(rows.number(number)), rows.number(value));
  const double dx = half_step(x), dy = half_step(y);
  std::map<int, Block> cells;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const int a = static_cast<int>(attractor[i]);
    cells.try_emplace(a, Block("x, y, half a cell")).first->second.row({x[i], y[i], dx, dy});
  }
  const auto style = style_of(folder);
  Figure f{.name = "basin", .source = "basin.json"};
  const Limits across(x), up(y);
  Panel panel{.title = axis_title(document, "basin.y"), .axis = {up.least - dy, up.most + dy}, .curves = {}};
  for (const auto& [a, block] : cells) {
    std::string title = "failed";
    if (a >= 0) {
      const auto path = fmt::format("basin.attractors.{}.", a);
      title = document.text(path + "kind");
      if (const auto it = exponents.find(a); it != exponents.end() && !std::isnan(it->second))
        title +=
            std::isfinite(it->second) ? fmt::format(", exponent {:.3g} 1/s", it->second) : ", exponent -∞";
      if (const auto cycle = document.text(path + "cycle"); !cycle.empty() && cycle.size() < 60)
        title += ": " + cycle;
    }
    add_curve(
        f, panel, block,
        Script().add("using 1:2:3:4 with boxxyerror fs solid noborder lc rgb 0x{:06x}", colour_of(style, a)),
        std::move(title));
  }
  add_panels(f, style,
             {.abscissa = {axis_title(document, "basin.x"), {across.least - dx, across.most + dx}},
              .panels = {std::move(panel)},
              .each = 8.4});
  return {draw(f, folder)};
}

// Convergence of the Lyapunov exponents: their means from the end of the transient to each time.

/// Curves beyond this number are not distinguished; the file has all.
constexpr int most_exponents = 9;

std::vector<std::filesystem::path> draw_lyapunov(const std::filesystem::path& folder) {
  Rows rows(folder / "lyapunov.csv");
  const auto t = rows.place("t"), sum = rows.place("sum"), predicted = rows.place("sum_predicted");
  std::vector<std::size_t> places;
  for (int i = 1; i <= most_exponents && rows.has(fmt::format("exponent_{}", i)); ++i)
    places.push_back(rows.place(fmt::format("exponent_{}", i)));
  Figure f{.name = "lyapunov", .height_cm = 9, .source = "lyapunov.json"};
  f.blocks.emplace_back("t (s), means of the exponents (1/s), of their sum, predicted sum");
  std::vector<bool> any(places.size() + 2);
  while (rows.next()) {
    std::vector<double> line{rows.number(t)};
    for (const auto place : places) line.push_back(rows.maybe_number(place));
    line.push_back(rows.maybe_number(sum));
    line.push_back(rows.maybe_number(predicted));
    for (std::size_t i = 0; i < any.size(); ++i) any[i] = any[i] || std::isfinite(line[i + 1]);
    f.blocks.back().row(line);
  }
  Script plot;
  const auto add = [&](std::size_t i, Script how) {
    if (any[i])
      plot.add("{}DATA index 0 using 1:{} {}", plot.empty() ? Word("plot ") : Word(", "), i + 2, how);
  };
  for (std::size_t i = 0; i < places.size(); ++i)
    add(i, Script().add("with lines lw 1.5 lc rgb C{} title {} noenhanced", i + 1,
                        fmt::format("exponent {}", i + 1)));
  add(places.size(), Script().add("with lines lw 1.5 lc rgb 0x444444 title 'sum'"));
  add(places.size() + 1,
      Script().add("every 8 with points pt 6 ps 0.7 lc rgb 0x444444 title 'sum predicted'"));
  if (plot.empty()) return {};
  f.script.add(
      "set xlabel 'Time (s)'\nset ylabel 'Mean since the transient (1/s)'\n"
      "set arrow 1 from graph 0, first 0 to graph 1, first 0 nohead lc rgb 0x888888 dt 3\n"
      "set key outside top center horizontal font SMALL\n{}\n",
      plot);
  return {draw(f, folder)};
}

}  // namespace

const Drawing bifurcation{{"bifurcation.json"}, draw_bifurcation};
const Drawing basin{{"basin.json"}, draw_basin};
const Drawing lyapunov{{"lyapunov.json"}, draw_lyapunov};

}  // namespace freeplay::plots
