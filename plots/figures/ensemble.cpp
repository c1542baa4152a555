// Bands of an ensemble: the quantiles over its starts at each time, 5 to 95 % and 25 to 75 %, and
// the median.
#include <fmt/format.h>

#include <algorithm>

#include "plots/drawing/column_title.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/figures/ensemble.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_ensemble(const std::filesystem::path& folder) {
  Figure f{.name = "ensemble", .source = "ensemble.json"};
  if (!add_bands(f, folder, {})) return {};
  return {draw(f, folder)};
}

}  // namespace

bool add_bands(Figure& f, const std::filesystem::path& folder, const std::vector<std::string>& chosen) {
  constexpr const char* quantiles[] = {"q05", "q25", "q50", "q75", "q95"};
  const ReadTable table(folder / "bands.csv", {"column"}, {"t", "q05", "q25", "q50", "q75", "q95"});
  const auto& name = table.text("column");
  std::vector<std::string> names;
  for (const auto& n : name)
    if ((chosen.empty() || std::ranges::find(chosen, n) != chosen.end()) &&
        std::ranges::find(names, n) == names.end() && names.size() < most_bands)
      names.push_back(n);
  if (names.empty()) return false;
  PanelStack stack{.abscissa = {time_title(), {}}, .panels = {}, .each = names.size() == 1 ? 6.0 : 3.6};
  Limits time;
  for (const auto& column : names) {
    Limits values;
    for (std::size_t i = 0; i < table.rows(); ++i)
      if (name[i] == column) values.hold(table.column("q05")[i]), values.hold(table.column("q95")[i]);
    const auto unit = fitting_unit(unit_of_column(column), values.size());
    Block block(fmt::format("{} ({}): t (s), quantiles 5, 25, 50, 75, 95 %", column, unit.name));
    for (std::size_t i = 0; i < table.rows(); ++i) {
      if (name[i] != column) continue;
      std::vector<double> row{table.column("t")[i]};
      for (const char* q : quantiles) row.push_back(table.column(q)[i] / unit.size);
      time.hold(row[0]);
      block.row(row);
    }
    const auto k = f.blocks.size();
    const bool keyed = k == 0;
    stack.panels.push_back(
        {.title = title_of_column(column, unit.name),
         .axis = axis_of(values.least / unit.size, values.most / unit.size),
         .curves = {{Script().add("DATA index {} using 1:2:6 with filledcurves lc rgb C2", k),
                     keyed ? "5 to 95 %" : ""},
                    {Script().add("DATA index {} using 1:3:5 with filledcurves lc rgb C1", k),
                     keyed ? "25 to 75 %" : ""},
                    {Script().add("DATA index {} using 1:4 with lines lw 1.5 lc rgb C1", k),
                     keyed ? "median" : ""}}});
    f.blocks.push_back(std::move(block));
  }
  stack.abscissa.axis = {time.least, time.most};
  f.script.add("set style fill transparent solid 0.25 noborder\n");
  add_panels(f, style_of(folder), std::move(stack));
  return true;
}

const Drawing ensemble{{"ensemble.json"}, draw_ensemble};

}  // namespace freeplay::plots
