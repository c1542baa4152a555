// Bands of an ensemble: the quantiles over its starts at each time, 5 to 95 % and 25 to 75 %, and
// the median.
#include <fmt/format.h>

#include <algorithm>

#include "plots/drawing/figure.hpp"
#include "plots/figures/ensemble.hpp"
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
  const Table table(folder / "bands.csv", {"column"}, {"t", "q05", "q25", "q50", "q75", "q95"});
  const auto& name = table.text("column");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (!chosen.empty() && std::ranges::find(chosen, name[i]) == chosen.end()) continue;
    if (names.empty() || names.back() != name[i]) {
      if (names.size() == most_bands) break;
      names.push_back(name[i]);
      f.blocks.emplace_back(name[i] + ": t (s), quantiles 5, 25, 50, 75, 95 %");
    }
    std::vector<double> row;
    for (const char* column : {"t", "q05", "q25", "q50", "q75", "q95"})
      row.push_back(table.column(column)[i]);
    f.blocks.back().row(row);
  }
  if (names.empty()) return false;
  f.height_cm = 3 + 5 * static_cast<double>(names.size());
  f.script.add(
      "set multiplot layout {},1 margins X(2.4),1-X(0.4),Y(1.15),1-Y(1.1) spacing 0,Y(1.6)\n"
      "set style fill transparent solid 0.25 noborder\nset key center at graph 0.5, graph 1.09 "
      "horizontal maxrows 1 samplen 2 font SMALL\nset xlabel 'Time (s)'\n",
      names.size());
  for (std::size_t i = 0; i < names.size(); ++i)
    f.script.add(
        "set ylabel {0} noenhanced\nplot DATA index {1} using 1:2:6 with filledcurves lc rgb C2 title {2}, '' index {1} "
        "using 1:3:5 with filledcurves lc rgb C1 title {3}, '' index {1} using 1:4 with lines lw 1.5 lc rgb C1 title {4}\n"
        "unset key\n",
        names[i], i, Word("'5 to 95 %'"), Word("'25 to 75 %'"), Word("'median'"));
  f.script.add("unset multiplot\n");
  return true;
}

const Drawing ensemble{{"ensemble.json"}, draw_ensemble};

}  // namespace freeplay::plots
