#include "plots/drawing/column_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "io/files/visible.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/figure.hpp"
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
      throw SceneError(folder.string() + ": contains no run; give a folder made by freeplay run or compare");
    const auto name = std::filesystem::absolute(folder).lexically_normal().filename().string();
    for (const auto& run : runs)
      list.push_back({plot.folders.size() == 1 ? run.title
                      : runs.size() == 1       ? name
                                               : name + ", " + run.title,
                      run.style, RunColumns(run.folder)});
  }
  return list;
}

/// The column of this name in the first run that has it. Throws SceneError if no run has it.
const Column& known(const std::vector<Run>& runs, const std::string& name) {
  for (const auto& run : runs)
    if (const auto* column = run.columns.find(name)) return *column;
  std::vector<Column> all;
  for (const auto& run : runs)
    for (const auto& c : run.columns.all())
      if (std::ranges::find(all, c.name, &Column::name) == all.end()) all.push_back(c);
  throw SceneError(no_column(name, all));
}

/// The panels of the figure: columns requested together share a panel if their units are equal.
std::vector<std::vector<Column>> panels_of(const ColumnPlot& plot, const std::vector<Run>& runs) {
  std::vector<std::vector<Column>> list;
  for (const auto& requested : plot.panels) {
    const auto first = list.size();
    for (const auto& name : requested) {
      const auto& column = known(runs, name);
      const auto same = std::find_if(list.begin() + static_cast<std::ptrdiff_t>(first), list.end(),
                                     [&](const auto& panel) { return panel.front().unit == column.unit; });
      if (same == list.end())
        list.push_back({column});
      else
        same->push_back(column);
    }
  }
  if (list.size() > most_panels)
    throw SceneError(fmt::format("{} panels, but a figure has at most {}; draw several figures", list.size(),
                                 most_panels));
  return list;
}

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : fmt::format("{} ({})", name, unit);
}

std::string label_of(const Column& x) {
  return x.name == "t"             ? "Time (s)"
         : x.name == "crank_angle" ? "Crank angle (rad)"
                                   : with_unit(x.name, x.unit);
}

std::string label_of(const std::vector<Column>& panel) {
  std::string names;
  for (const auto& c : panel) names += (names.empty() ? "" : ", ") + c.name;
  const auto& unit = panel.front().unit;
  // the key has the names
  if (names.size() > 30) return unit.empty() ? "" : fmt::format("({})", unit);
  return with_unit(names, unit);
}

/// Whether both axes are lengths, as for the path of a point; the axes then have the same scale.
bool is_path(const Column& x, const std::vector<std::vector<Column>>& panels,
             const std::optional<Crossing>& section) {
  return panels.size() == 1 && x.name != "t" && x.unit == "m" && panels[0].front().unit == "m" && !section;
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
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), s.value);
  if (error != std::errc() || end != value.data() + value.size() || !std::isfinite(s.value)) throw wrong();
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
  const auto x = known(runs, plot.x);
  const auto panels = panels_of(plot, runs);
  if (panels.empty()) throw SceneError("no column to draw; give columns with --y");
  const double from = plot.from.value_or(-INFINITY), to = plot.to.value_or(INFINITY);
  if (from >= to) throw SceneError(fmt::format("--from {} must be less than --to {}", from, to));

  std::string name = plot.name;
  if (name.empty()) {
    for (const auto& panel : panels)
      for (const auto& c : panel) name += (name.empty() ? "" : "-") + c.name;
    name = file_name("plot", plot.x == "t" ? name : name + "-over-" + plot.x);
  }
  const bool path = is_path(x, panels, plot.section);
  const auto count = static_cast<double>(panels.size());
  Figure f{.name = name,
           .height_cm = panels.size() == 1 ? (path ? 12 : 9) : 2.6 + 3.6 * count,
           .source = std::filesystem::exists(plot.folders.front() / "comparison.json") ? "comparison.json"
                                                                                       : "run.json",
           .formats = plot.formats};
  f.script.add(
      "set multiplot layout {},1 margins X(1.9),1-X(0.5),Y(1.5),1-Y(0.9) spacing 0,Y(0.75)\n"
      "set key at graph 1, graph 1 right bottom horizontal maxrows 1 samplen 2 noenhanced\n{}",
      panels.size(), path ? Word("set size ratio -1\n") : Word(""));
  if (panels.size() > 1) f.script.add("set format x ''\n");
  bool drawn = false;
  std::string without_rows;
  for (std::size_t k = 0; k < panels.size(); ++k) {
    Script curves;
    const bool alone = runs.size() == 1 && panels[k].size() == 1;
    std::size_t curve = 0, named = 0;
    for (const auto& wanted : panels[k])
      for (const auto& run : runs) {
        const auto *own_x = run.columns.find(x.name), *own_y = run.columns.find(wanted.name);
        if (!own_x || !own_y) continue;  // an ideal mechanism has no contacts
        if (++curve > most_curves)
          throw SceneError(fmt::format("more than {} curves in a panel; draw several figures", most_curves));
        const auto points = thinned(run.columns.read(*own_x, *own_y, from, to, plot.section), most_points);
        if (!points.without_rows.empty()) without_rows = points.without_rows;
        Block block(fmt::format("{}: {}, {}", run.title, with_unit(x.name, x.unit),
                                with_unit(wanted.name, wanted.unit)));
        for (std::size_t i = 0; i < points.x.size(); ++i) block.row({points.x[i], points.y[i]});
        const bool marks = plot.section || own_y->file == "events.csv";
        const auto title = panels[k].size() == 1 ? run.title
                           : runs.size() == 1    ? wanted.name
                                                 : wanted.name + ", " + run.title;
        // With one column each formulation has its usual line style; with several each curve has
        // its own.
        const auto look = static_cast<std::size_t>(
            panels[k].size() == 1 && plot.folders.size() == 1 ? run.style - 1 : curve - 1);
        curves.add("{}DATA index {} using 1:2 with ", curves.empty() ? Word("plot ") : Word(", "),
                   f.blocks.size());
        if (marks)
          curves.add("points pt {} ps 0.8 lc rgb C{}", 6 + look % 8, 1 + look % 9);
        else
          curves.add("lines lw 1.2 dt {} lc rgb C{}", alone ? dashes[0] : dashes[look % std::size(dashes)],
                     1 + look % 9);
        if (alone)
          curves.add(" notitle");
        else
          curves.add(" title {}", title), ++named;
        drawn = drawn || !block.empty();
        f.blocks.push_back(std::move(block));
      }
    if (named > 4) f.script.add("set key maxrows 2 font TINY\n");
    if (k + 1 == panels.size()) f.script.add("set format x\nset xlabel {} noenhanced\n", label_of(x));
    f.script.add("set ylabel {} noenhanced\n{}\n{}", label_of(panels[k]), curves,
                 k == 0 ? Word("unset label 100\n") : Word(""));
  }
  if (!drawn && !without_rows.empty()) throw SceneError(without_rows + ": has no rows");
  if (!drawn)
    throw SceneError(plot.section ? "no row crosses the section within that time"
                                  : "no row within that time");
  f.script.add("unset multiplot\n");
  return draw(f, plot.folders.front());
}

}  // namespace freeplay::plots
