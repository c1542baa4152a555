// A measured mean turn with both formulations' over it.
#include <fmt/format.h>

#include "plots/figure.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_all(const std::filesystem::path& folder) {
  const Csv csv(folder / "overlay.csv");
  const auto angle = csv.column("crank_angle");
  Figure f;
  f.name = "overlay";
  f.source = "validation.json";
  for (const char* name : {"measured", "penalty", "nonsmooth"}) {
    const auto y = csv.column(name);
    std::string block = fmt::format("# crank angle (deg), {} (m/s^2)\n", name);
    for (std::size_t i = 0; i < y.size(); ++i) block += fmt::format("{} {}\n", angle[i], y[i]);
    f.blocks.push_back(block);
  }
  f.script =
      "set xlabel 'Crank angle (°)'\nset xrange [0:360]\nset xtics 45\nset ylabel 'Acceleration, mean turn "
      "(m/s²)'\nset key outside top center horizontal\nplot 'DATA' index 0 using 1:2 with lines lc rgb "
      "'#888888' lw 4 title 'measured', 'DATA' index 1 using 1:2 with lines ls 1 title 'penalty', 'DATA' "
      "index 2 using 1:2 with lines ls 2 title 'nonsmooth'\n";
  return {draw(f, folder)};
}

}  // namespace

const Drawing overlay{{"validation.json"}, draw_all};

}  // namespace freeplay::plots
