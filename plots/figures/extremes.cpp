// The map of the extremes. Each axis has a panel: one column per value, one row per formulation,
// with the predicted limits as lines. A further panel shows scenes that are extreme in themselves.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mechanism/error.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/style.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

struct Kind {
  const char* name;
  Word look;
};
constexpr Kind kinds[] = {{"right", "pt 7 lc rgb (MONO ? 0 : 0x1a7f37)"},
                          {"degraded", "pt 9 lc rgb (MONO ? 0 : 0xd29922)"},
                          {"refused", "pt 4 lc rgb (MONO ? 0 : 0x555555)"},
                          {"defect", "pt 2 lw 2 lc rgb (MONO ? 0 : 0xcf222e)"}};
constexpr Word limit_look = "lw 2 dt 1 lc rgb C1";
constexpr std::size_t most_panels = 100;

struct Mark {
  std::size_t x, y;
  int kind;
};
struct CellPanel {
  std::string name;
  std::vector<std::string> columns, rows;  ///< names of the tics
  std::vector<double> values;              ///< values of the columns; empty for scenes
  std::vector<Mark> marks;
  std::vector<std::pair<double, std::size_t>> limits;  ///< position among the columns, row
};

Script tics(const std::vector<std::string>& names) {
  Script list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    auto name = names[i];
    // 1e+05 as 1e5: room
    for (const auto& [longer, shorter] : {std::pair{"e+0", "e"}, {"e-0", "e-"}})
      if (const auto at = name.find(longer); at != name.npos) name.replace(at, 3, shorter);
    if (name == "0.0001") name = "1e-4";
    list.add("{}", i ? Word(", ") : Word("(")).add_tic(name, i);
  }
  return list.add(")");
}

/// Position of a value among the columns, interpolated (logarithmically between positive values);
/// NaN outside.
double place_among(const std::vector<double>& values, double x) {
  for (std::size_t i = 0; i + 1 < values.size(); ++i) {
    const double a = values[i], b = values[i + 1];
    if (x < a || x > b) continue;
    return static_cast<double>(i) + (a > 0 ? std::log(x / a) / std::log(b / a) : (x - a) / (b - a));
  }
  return NAN;
}

std::vector<CellPanel> read_panels(const std::filesystem::path& folder) {
  const ReadTable csv(folder / "extremes.csv", {"formulation", "outcome"}, {"value"}, {"axis", "label"});
  const ReadTable limits(folder / "limits.csv", {"formulation"}, {"value"}, {"axis"});
  const auto &axis = csv.text("axis"), &label = csv.text("label"), &formulation = csv.text("formulation"),
             &outcome = csv.text("outcome");
  const auto& value = csv.column("value");
  std::vector<std::string> names;
  std::vector<CellPanel> panels;
  for (std::size_t i = 0; i < csv.rows(); ++i) {
    const auto at = place_in(names, axis[i]);
    if (at == panels.size()) panels.push_back({axis[i], {}, {}, {}, {}, {}});
    if (panels.size() > most_panels)
      throw SceneError(
          fmt::format("{}: has more than {} axes", (folder / "extremes.csv").string(), most_panels));
    auto& p = panels[at];
    const bool scene = axis[i] == "scene";
    const auto x = place_in(p.columns, scene ? formulation[i] : label[i]),
               y = place_in(p.rows, scene ? label[i] : formulation[i]);
    if (!scene && x == p.values.size()) p.values.push_back(value[i]);
    int kind = 0;
    while (kind < 3 && outcome[i] != kinds[kind].name) ++kind;
    p.marks.push_back({x, y, kind});
  }
  const auto& limit = limits.column("value");
  for (std::size_t i = 0; i < limits.rows(); ++i)
    for (auto& p : panels) {
      const double x = p.name == limits.text("axis")[i] ? place_among(p.values, limit[i]) : NAN;
      if (std::isfinite(x)) p.limits.push_back({x, place_in(p.rows, limits.text("formulation")[i])});
    }
  return panels;
}

// cm
double height(const CellPanel& p) { return 1.05 + 0.42 * static_cast<double>(p.rows.size()); }

std::vector<std::filesystem::path> draw_extremes(const std::filesystem::path& folder) {
  const auto panels = read_panels(folder);
  const double total = std::accumulate(panels.begin(), panels.end(), 0.0,
                                       [](double sum, const CellPanel& p) { return sum + height(p); });
  Figure f{.name = "extremes", .width_cm = 20, .source = "extremes.json"};
  const auto style = style_of(folder);
  const double unit = style.font_size / Style::usual_font_size;  // panel heights follow the texts
  f.sized = true;
  f.width_cm = width_of(f, style);
  const bool one = f.width_cm < 16 * unit;
  // Two columns if there is room. The second begins after half of the total height.
  std::vector<int> column;
  double filled[2] = {0, 0};
  for (const auto& p : panels) {
    column.push_back(!one && !column.empty() &&
                     (column.back() == 1 || filled[0] + height(p) / 2 > total / 2));
    filled[column.back()] += height(p);
  }
  if (panels.empty()) return {};
  const double top = one ? 1.5 : 1.1, bottom = 0.5;  // cm, for the key and the origin
  const double all = std::max(filled[0], filled[1]) + top + bottom;
  f.height_cm = unit * all;
  f.script.add(
      "set multiplot\nset key at screen 0.5, screen 1-Y(0.15) center top vertical maxrows {} {}\nset tics "
      "scale 0 "
      "font SMALL\n",
      one ? 2 : 1, one ? Word("font SMALL") : Word(""));
  double down[2] = {top, top};
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const auto& p = panels[i];
    double& y = down[column[i]];
    const double from = 1 - (y + 0.45) / all, to = 1 - (y + height(p) - 0.6) / all;
    y += height(p);
    f.script.add(
        "set lmargin at screen {}\nset rmargin at screen {}\nset tmargin at screen {:.5f}\nset bmargin at "
        "screen {:.5f}\n",
        column[i] ? 0.70
        : one     ? 2.2 * unit / f.width_cm
                  : 0.11,
        column[i] || one ? 0.985 : 0.44, from, to);
    f.script.add(
        "set label 1 {} at graph 0, graph 1 left offset 0,0.6 font SMALL noenhanced\nset xrange "
        "[-0.5:{}]\nset yrange [{}:-0.5] noreverse\nset xtics {} noenhanced\nset ytics {} noenhanced\nunset "
        "arrow\n",
        p.name == "scene" ? std::string("scenes") : p.name, static_cast<double>(p.columns.size()) - 0.5,
        static_cast<double>(p.rows.size()) - 0.5, tics(p.columns), tics(p.rows));
    for (const auto& [x, row] : p.limits)
      f.script.add("set arrow from first {0:.4f},{1} to first {0:.4f},{2} nohead {3}\n", x,
                   static_cast<double>(row) - 0.5, static_cast<double>(row) + 0.5, limit_look);
    Script plot;
    const auto next = [&] { return plot.empty() ? Word("plot ") : Word(", "); };
    for (int k = 0; k < 4; ++k) {
      Block block(fmt::format("{}, {}: column, row", p.name, kinds[k].name));
      for (const auto& m : p.marks)
        if (m.kind == k) block.row({static_cast<double>(m.x), static_cast<double>(m.y)});
      if (i == 0) plot.add("{}NaN with points {} ps 1.1 title {}", next(), kinds[k].look, kinds[k].name);
      if (block.empty()) continue;
      plot.add("{}DATA index {} using 1:2 with points {} ps 1.1 notitle", next(), f.blocks.size(),
               kinds[k].look);
      f.blocks.push_back(block);
    }
    if (i == 0) plot.add("{}NaN with lines {} title 'predicted limit'", next(), limit_look);
    f.script.add("{}\n", plot);  // the origin is written once
  }
  f.script.add("unset multiplot\n");
  return {draw(f, folder)};
}

}  // namespace

const Drawing extremes{{"extremes.json"}, draw_extremes};

}  // namespace freeplay::plots
