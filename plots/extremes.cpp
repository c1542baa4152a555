// The map of the extremes: one strip for each axis and formulation, a mark for each cell, predicted limits
// over it.
#include <fmt/format.h>

#include <algorithm>

#include "plots/figure.hpp"

namespace freeplay::plots {

std::filesystem::path extremes(const std::filesystem::path& folder) {
  const Csv csv(folder / "extremes.csv"), limits(folder / "limits.csv");
  const auto &axis = csv.text("axis"), &formulation = csv.text("formulation"), &outcome = csv.text("outcome");
  const auto value = csv.column("value");
  std::vector<std::string> strips;
  const auto strip = [&](const std::string& name) {
    const auto it = std::ranges::find(strips, name);
    if (it != strips.end()) return it - strips.begin();
    strips.push_back(name);
    return static_cast<long>(strips.size()) - 1;
  };
  const std::pair<const char*, const char*> kinds[] = {{"right", "pt 7 lc rgb '#1a7f37'"},
                                                       {"degraded", "pt 9 lc rgb '#d29922'"},
                                                       {"refused", "pt 4 lc rgb '#555555'"},
                                                       {"defect", "pt 2 lw 2 lc rgb '#cf222e'"}};
  std::string blocks[4];
  for (std::size_t i = 0; i < csv.rows(); ++i) {
    if (axis[i] == "scene") continue;
    const auto y = strip(axis[i] + ": " + formulation[i]);
    // A zero stands at the left end of its logarithmic axis.
    const int kind = outcome[i] == "right"      ? 0
                     : outcome[i] == "degraded" ? 1
                     : outcome[i] == "refused"  ? 2
                                                : 3;
    blocks[kind] += fmt::format("{} {}\n", value[i] > 0 ? value[i] : 1e-9, y);
  }
  Figure f;
  f.name = "extremes";
  f.height_cm = 14;
  f.width_cm = 18;
  f.script =
      "set logscale x\nset xrange [3e-10:4e6]\nset format x '10^{%T}'\nset key outside top center "
      "horizontal\nset lmargin at screen "
      "0.36\nset yrange "
      "[" +
      fmt::format("{}", strips.size()) + ":-1] noreverse\nset ytics (";
  for (std::size_t i = 0; i < strips.size(); ++i)
    f.script += fmt::format("{}'{}' {}", i ? ", " : "", strips[i], i);
  f.script += ")\nset xlabel 'value on each axis (zeros at the left)'\n";
  const auto names = limits.column("value");
  for (std::size_t i = 0; i < limits.rows(); ++i) {
    const auto y = static_cast<double>(strip(limits.text("axis")[i] + ": " + limits.text("formulation")[i]));
    f.script += fmt::format("set arrow from {0},{1} to {0},{2} nohead lw 2 dt 1 lc rgb '#0b3c8c'\n", names[i],
                            y - 0.45, y + 0.45);
  }
  std::string plot = "plot ";
  for (int k = 0; k < 4; ++k) {
    if (blocks[k].empty()) continue;
    f.blocks.push_back(fmt::format("# value, strip: {}\n", kinds[k].first) + blocks[k]);
    plot += fmt::format("'DATA' index {} using 1:2 with points {} ps 1.3 title '{}', ", f.blocks.size() - 1,
                        kinds[k].second, kinds[k].first);
  }
  f.script += plot + "NaN lw 2 dt 1 lc rgb '#0b3c8c' title 'predicted limit'\n";
  return draw(f, folder);
}

}  // namespace freeplay::plots
