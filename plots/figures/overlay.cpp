// The measured mean turn, with those of both formulations over it.
#include <fmt/format.h>

#include "plots/drawing/figure.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_overlay(const std::filesystem::path& folder) {
  const std::vector<std::string> curves{"measured", "penalty", "nonsmooth"};
  const Table table(folder / "overlay.csv", {}, {"crank_angle", "measured", "penalty", "nonsmooth"});
  if (table.rows() == 0) return {};
  const auto& angle = table.column("crank_angle");
  Figure f{.name = "overlay", .source = "validation.json"};
  for (const auto& name : curves) {
    auto& block = f.blocks.emplace_back(fmt::format("crank angle (deg), {} (m/s^2)", name));
    for (std::size_t i = 0; i < table.rows(); ++i) block.row({angle[i], table.column(name)[i]});
  }
  f.script.add(
      "set xlabel 'Crank angle (°)'\nset xrange [0:360]\nset xtics 45\nset ylabel 'Acceleration, mean turn "
      "(m/s²)'\nset key outside top center horizontal\nplot DATA index 0 using 1:2 with lines lc rgb "
      "0x888888 lw 4 title 'measured', DATA index 1 using 1:2 with lines ls 1 title 'penalty', DATA "
      "index 2 using 1:2 with lines ls 2 title 'nonsmooth'\n");
  return {draw(f, folder)};
}

}  // namespace

const Drawing overlay{{"validation.json"}, draw_overlay};

}  // namespace freeplay::plots
