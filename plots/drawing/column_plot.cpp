#include "plots/drawing/column_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/files/escaping.hpp"
#include "io/scene/points_file.hpp"
#include "io/scene/quantity.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/axis.hpp"
#include "plots/drawing/column_title.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/run_facts.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t most_panels = 6, most_curves = 18, most_points = 20'000;
constexpr Word dashes[] = {"1", "(12,5)", "(3,4)", "(14,4,3,4)", "(6,4)", "(1,3)"};

struct Run {
  std::string title;
  int style;
  RunColumns columns;
};

std::vector<Run> runs_of(const ColumnPlot& plot) {
  std::vector<Run> list;
  for (const auto& folder : plot.folders) {
    const auto runs = runs_in(folder);
    if (runs.empty())
      throw SceneError(folder.string() +
                       ": contains no run; give a folder made by freeplay run, compare or orbit");
    const auto name = std::filesystem::absolute(folder).lexically_normal().filename().string();
    for (const auto& run : runs)
      list.push_back({plot.folders.size() == 1 ? run.title
                      : runs.size() == 1       ? name
                                               : name + ", " + run.title,
                      run.style, RunColumns(run.folder)});
  }
  return list;
}

/// The columns of all runs; of equal names, that of the first run.
std::vector<Column> columns_of(const std::vector<Run>& runs) {
  std::vector<Column> all;
  for (const auto& run : runs)
    for (const auto& c : run.columns.all())
      if (std::ranges::find(all, c.name, &Column::name) == all.end()) all.push_back(c);
  return all;
}

/// The formula with the columns of a run; empty if the run lacks one. An ideal mechanism has no
/// contacts.
std::optional<ColumnFormula> of_run(const ColumnFormula& formula, const Run& run) {
  auto own = formula;
  for (auto& column : own.columns) {
    const auto* found = run.columns.find(column.name);
    if (!found) return std::nullopt;
    column = *found;
  }
  return own;
}

/// Formulas of one unit, with their curves.
struct ColumnPanel {
  std::vector<ColumnFormula> formulas;
  ShownUnit unit;
  std::vector<Points> points = {};  ///< of each formula and run
  std::vector<const Run*> runs = {};
  std::vector<std::size_t> of = {};  ///< index of its formula
};

/// The panels of the figure: columns requested together share a panel if their units are equal.
std::vector<ColumnPanel> panels_of(const ColumnPlot& plot, const std::vector<Column>& all) {
  std::vector<ColumnPanel> list;
  for (const auto& requested : plot.panels) {
    const auto first = list.size();
    for (const auto& name : requested) {
      auto formula = formula_of(name, all);
      const auto same =
          std::find_if(list.begin() + static_cast<std::ptrdiff_t>(first), list.end(), [&](const auto& panel) {
            const auto& unit = panel.formulas.front().unit;
            return unit == formula.unit || (!unit.empty() && same_quantity(unit, formula.unit));
          });
      if (same == list.end())
        list.push_back({{std::move(formula)}, {}});
      else
        same->formulas.push_back(std::move(formula));
    }
  }
  if (list.size() > most_panels)
    throw SceneError(fmt::format("{} panels, but a figure has at most {}; draw several figures", list.size(),
                                 most_panels));
  return list;
}

/// The unit requested for an axis; empty if there is none. `name`: x or y1 …; `used`: of each
/// request. Throws SceneError if a request names the axis and has another dimension.
std::optional<ShownUnit> requested_unit(const ColumnPlot& plot, const std::string& name,
                                        const std::string& si, std::vector<bool>& used) {
  std::optional<ShownUnit> shown;
  for (std::size_t i = 0; i < plot.units.size(); ++i) {
    const auto& text = plot.units[i];
    const auto equals = text.find('=');
    const auto axis = equals == text.npos ? "" : text.substr(0, equals);
    const auto unit = equals == text.npos ? text : text.substr(equals + 1);
    const bool all = axis == "y" && name.front() == 'y';
    if (!axis.empty() && axis != name && !all) continue;
    if ((axis.empty() || all) && !same_quantity(unit, si)) continue;
    used[i] = true;
    const auto wanted = dimension_of(si), given = dimension_of(unit);
    if (given && *given != wanted)
      throw SceneError(fmt::format("--unit {}: is {}, but axis {} is {}", visible_brief(text, 60),
                                   name_of(*given), name, name_of(*wanted)));
    if (!given) throw SceneError(fmt::format("--unit {}: is not a known unit", visible_brief(text, 60)));
    if (!shown || !axis.empty()) shown = unit_named(unit, si);
  }
  return shown;
}

/// Refuses requests of units that no axis used.
void refuse_unused(const ColumnPlot& plot, const std::vector<bool>& used, const std::string& axes) {
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i]) continue;
    const auto& text = plot.units[i];
    const auto unit = text.substr(text.find('=') + 1);
    if (dimension_of(unit).has_value() && !unit.empty())
      throw SceneError(fmt::format("--unit {}: no such axis of {}; the axes are {}", visible_brief(text, 60),
                                   quantity_name(unit), axes));
    throw SceneError(fmt::format("--unit {}: \"{}\" is not a known unit; the axes are {}",
                                 visible_brief(text, 60), visible_brief(unit, 40), axes));
  }
}

/// Whether both axes are lengths, as for the path of a point; the axes then have the same scale.
bool is_path(const ColumnFormula& x, const std::vector<ColumnPanel>& panels,
             const std::optional<Crossing>& section) {
  return panels.size() == 1 && x.unit == "m" && panels[0].formulas.front().unit == "m" && !section;
}

double greatest_of(const std::vector<double>& values) {
  double g = 0;
  for (const double v : values) g = std::max(g, std::abs(v));
  return g;
}

constexpr double full_turn = 2 * std::numbers::pi;

/// Reads the curves of the panels. Returns the greatest magnitude of x.
double read_curves(std::vector<ColumnPanel>& panels, const ColumnFormula& x, const std::vector<Run>& runs,
                   const ColumnPlot& plot, std::string& without_rows) {
  const double from = plot.from.value_or(-INFINITY), to = plot.to.value_or(INFINITY);
  double greatest = 0;
  for (auto& panel : panels) {
    double most = 0;
    for (std::size_t k = 0; k < panel.formulas.size(); ++k)
      for (const auto& run : runs) {
        const auto own_x = of_run(x, run), own_y = of_run(panel.formulas[k], run);
        if (!own_x || !own_y) continue;
        if (panel.points.size() == most_curves)
          throw SceneError(fmt::format("more than {} curves in a panel; draw several figures", most_curves));
        auto points = thinned(run.columns.read(*own_x, *own_y, from, to, plot.section), most_points);
        if (!points.without_rows.empty()) without_rows = points.without_rows;
        greatest = std::max(greatest, greatest_of(points.x));
        most = std::max(most, greatest_of(points.y));
        panel.points.push_back(std::move(points));
        panel.runs.push_back(&run);
        panel.of.push_back(k);
      }
    panel.unit = fitting_unit(panel.formulas.front().unit, most);
  }
  return greatest;
}

/// A block of data in the shown units. A folded curve has a gap where the angle wraps.
Block block_of(const std::string& heading, const Points& p, double x_size, double y_size, bool fold,
               Limits& across, Limits& up) {
  Block block(heading);
  double last = 0;
  for (std::size_t i = 0; i < p.x.size(); ++i) {
    const double turns = fold ? std::floor(p.x[i] / full_turn) : 0;
    if (i > 0 && turns != last) block.gap();
    last = turns;
    const double x = (p.x[i] - turns * full_turn) / x_size, y = p.y[i] / y_size;
    block.row({x, y});
    across.hold(x), up.hold(y);
  }
  return block;
}

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : fmt::format("{} ({})", name, unit);
}

/// A curve as "with lines …", and whether its panel shows one column only.
struct CurveLook {
  Script how;
  bool one;
};

/// Panels of one column each name the runs. The first of them names all; the others have no key.
void join_keys(std::vector<Panel>& panels, std::vector<std::vector<CurveLook>>& looks) {
  const auto one = [](const std::vector<CurveLook>& panel) { return !panel.empty() && panel[0].one; };
  const auto first = static_cast<std::size_t>(std::ranges::find_if(looks, one) - looks.begin());
  for (std::size_t k = first + 1; k < panels.size(); ++k) {
    if (!one(looks[k])) continue;
    auto &named = panels[first].curves, &curves = panels[k].curves;
    for (std::size_t i = 0; i < curves.size(); ++i) {
      if (curves[i].title.empty()) continue;
      const auto same = std::ranges::find(named, curves[i].title, &PanelCurve::title);
      const auto& how = looks[k][i].how;
      if (same == named.end()) {
        named.push_back({Script().add("keyentry with {}", how), curves[i].title});
        looks[first].push_back(looks[k][i]);
      } else if (looks[first][static_cast<std::size_t>(same - named.begin())].how.text() != how.text()) {
        continue;  // another mark: the panel names it again
      }
      curves[i].title.clear();
    }
  }
}

}  // namespace

Crossing crossing_of(const std::string& text) {
  const auto wrong = [&]() -> SceneError {
    return SceneError(fmt::format(
        "--section {}: must be COLUMN=VALUE or crank=DEGREES, followed by :up or :down for one direction",
        visible_brief(text, 60)));
  };
  const auto equals = text.find('=');
  if (equals == text.npos || equals == 0) throw wrong();
  Crossing s{text.substr(0, equals), 0, 0};
  auto value = text.substr(equals + 1);
  for (const auto& [end, sense] : {std::pair<std::string_view, int>{":up", 1}, {":down", -1}})
    if (value.ends_with(end)) value.resize(value.size() - end.size()), s.sense = sense;
  s.value = number_in(value).value_or(NAN);
  if (!std::isfinite(s.value)) throw wrong();
  return s;
}

Points thinned(const Points& p, std::size_t most) {
  const auto n = p.x.size();
  if (n <= most) return p;
  Points out;
  const auto add = [&](std::size_t i) {
    out.x.push_back(p.x[i]);
    out.y.push_back(p.y[i]);
  };
  if (!std::ranges::is_sorted(p.x)) {
    for (std::size_t i = 0; i < n; i += (n + most - 1) / most) add(i);
    return out;
  }
  const std::size_t each = (4 * n + most - 1) / most;
  for (std::size_t from = 0; from < n; from += each) {
    const std::size_t to = std::min(from + each, n);
    std::vector<std::size_t> kept{from, to - 1};
    const auto [least, greatest] = std::minmax_element(p.y.begin() + static_cast<std::ptrdiff_t>(from),
                                                       p.y.begin() + static_cast<std::ptrdiff_t>(to));
    kept.push_back(static_cast<std::size_t>(least - p.y.begin()));
    kept.push_back(static_cast<std::size_t>(greatest - p.y.begin()));
    std::ranges::sort(kept);
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    for (const auto i : kept) add(i);
  }
  return out;
}

std::filesystem::path draw_columns(const ColumnPlot& plot) {
  const auto runs = runs_of(plot);
  const auto all = columns_of(runs);
  const auto x = formula_of(plot.x, all);
  auto panels = panels_of(plot, all);
  if (panels.empty()) throw SceneError("no column to draw; give columns with --y");
  if (plot.from && plot.to && *plot.from >= *plot.to)
    throw SceneError(fmt::format("--from {} must be less than --to {}", *plot.from, *plot.to));
  if (plot.fold && !same_quantity(x.unit, "rad"))
    throw SceneError(fmt::format("--fold: {} is not an angle; fold over one, such as --over crank_angle",
                                 visible_brief(x.text, 60)));

  std::string name = plot.name;
  if (name.empty()) {
    for (const auto& panel : panels)
      for (const auto& f : panel.formulas) name += (name.empty() ? "" : "-") + f.text;
    name = file_name("plot", plot.x == "t" ? name : name + "-over-" + plot.x);
  }
  std::string without_rows;
  const double greatest_x = read_curves(panels, x, runs, plot, without_rows);

  // Units: those requested; else an angle of the crank in degrees, others with a fitting prefix.
  std::vector<bool> used(plot.units.size(), false);
  const bool degrees = plot.fold || x.text == "crank_angle";
  const bool path = is_path(x, panels, plot.section);
  auto x_unit = degrees ? unit_named("deg", x.unit) : fitting_unit(x.unit, greatest_x);
  if (path) x_unit = panels[0].unit = x_unit.size > panels[0].unit.size ? x_unit : panels[0].unit;
  std::string axes = fmt::format("x ({})", x.unit);
  if (const auto asked = requested_unit(plot, "x", x.unit, used)) x_unit = *asked;
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const auto axis = fmt::format("y{}", k + 1);
    const auto& si = panels[k].formulas.front().unit;
    axes += fmt::format(", {} ({})", axis, si);
    if (const auto asked = requested_unit(plot, axis, si, used)) panels[k].unit = *asked;
  }
  refuse_unused(plot, used, axes);

  Figure f{
      .name = name, .source = source_of(plot.folders.front()), .title = plot.title, .formats = plot.formats};
  for (const auto& list : plot.panels)
    for (const auto& y : list) f.caption += (f.caption.empty() ? "" : ", ") + y;
  f.caption += fmt::format(" over {}{}.", plot.x, plot.fold ? ", folded over a turn" : "");
  PanelStack stack{.abscissa = {},
                   .panels = {},
                   .each = panels.size() == 1 ? 7.0 : 3.4,
                   .equal_scales = path && x_unit.size == panels[0].unit.size};
  Limits across;
  bool drawn = false;
  const auto style = style_of(plot.folders.front());
  std::vector<std::vector<CurveLook>> looks(panels.size());
  for (const auto& panel : panels) {
    Panel shown{.title = title_of(panel.formulas, panel.unit.name), .axis = {}, .curves = {}};
    const bool one = panel.formulas.size() == 1, alone = one && panel.points.size() == 1;
    Limits up;
    for (std::size_t i = 0; i < panel.points.size(); ++i) {
      const auto& formula = panel.formulas[panel.of[i]];
      const auto& run = *panel.runs[i];
      const auto& points = panel.points[i];
      auto block = block_of(fmt::format("{}: {}, {}", run.title, with_unit(x.text, x_unit.name),
                                        with_unit(formula.text, panel.unit.name)),
                            points, x_unit.size, panel.unit.size, plot.fold, across, up);
      const bool events = !formula.columns.empty() && formula.columns[0].file == "events.csv";
      const bool fixed = !points.x.empty() && Limits(points.x).range() == 0 && Limits(points.y).range() == 0;
      // The runs of a comparison keep the colours of the formulations. Dashes distinguish the
      // columns, in a panel of one column the formulations. Otherwise each curve has its own look.
      const bool compared = plot.folders.size() == 1, dashed = !one && runs.size() > 1 && !style.monochrome &&
                                                               panel.formulas.size() <= std::size(dashes);
      const auto by_run = static_cast<std::size_t>(run.style - 1);
      const auto look = !one ? i : compared ? by_run : static_cast<std::size_t>(&run - runs.data());
      const auto colour = 1 + (compared && dashed ? by_run : look) % 9;
      const auto dash = alone ? 0 : (compared && dashed ? panel.of[i] : look) % std::size(dashes);
      PanelCurve curve;
      Script how;
      if (plot.section || events || fixed)
        how.add("points pt {} ps {} lc rgb C{}", fixed ? 7 : 6 + look % 8, fixed ? 1.0 : 0.8, colour);
      else
        how.add("lines lw 1.2 dt {} lc rgb C{}", dashes[dash], colour);
      curve.what.add("DATA index {} using 1:2 with {}", f.blocks.size(), how);
      looks[static_cast<std::size_t>(&panel - panels.data())].push_back({how, one});
      if (!alone)
        curve.title = one ? run.title : runs.size() == 1 ? formula.text : formula.text + ", " + run.title;
      shown.curves.push_back(std::move(curve));
      drawn = drawn || !block.empty();
      f.blocks.push_back(std::move(block));
    }
    shown.axis = axis_of(up.least, up.most);
    stack.panels.push_back(std::move(shown));
  }
  if (!drawn && !without_rows.empty()) throw SceneError(without_rows + ": has no rows");
  if (!drawn)
    throw SceneError(plot.section ? "no row crosses the section within that time"
                                  : "no row within that time");
  stack.abscissa = {title_of({x}, x_unit.name), axis_of(across.least, across.most)};
  auto& axis = stack.abscissa.axis;
  const bool in_degrees = x_unit.name == "°";
  axis.turn = in_degrees && across.most - across.least > 90;
  if (plot.fold)
    axis.low = 0, axis.high = full_turn / x_unit.size;
  else if (!path && across.most > across.least)
    axis.low = across.least, axis.high = across.most;
  join_keys(stack.panels, looks);
  add_panels(f, style, std::move(stack));
  return draw(f, plot.folders.front());
}

}  // namespace freeplay::plots
