// The measured mean turn, with those of both formulations over it.
#include <fmt/format.h>

#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_overlay(const std::filesystem::path& folder) {
  const std::vector<std::string> curves{"measured", "penalty", "nonsmooth"};
  const ReadTable table(folder / "overlay.csv", {}, {"crank_angle", "measured", "penalty", "nonsmooth"});
  if (table.rows() == 0) return {};
  const auto& angle = table.column("crank_angle");
  Figure f{.name = "overlay", .source = "validation.json"};
  for (const auto& name : curves) {
    auto& block = f.blocks.emplace_back(fmt::format("crank angle (deg), {} (m/s^2)", name));
    for (std::size_t i = 0; i < table.rows(); ++i) block.row({angle[i], table.column(name)[i]});
  }
  Limits up;
  for (const auto& name : curves)
    for (const double a : table.column(name)) up.hold(a);
  f.caption = "Mean turn of the acceleration.";
  Panel panel{.title = AxisTitle::of({"acceleration a", "acceleration $a$"}, "m/s²"),
              .axis = axis_of(up.least, up.most),
              .curves = {{Script().add("DATA index 0 using 1:2 with lines lc rgb 0x888888 lw 4"), "measured"},
                         {Script().add("DATA index 1 using 1:2 with lines ls 1"), "penalty"},
                         {Script().add("DATA index 2 using 1:2 with lines ls 2"), "nonsmooth"}}};
  add_panels(f, style_of(folder),
             {.abscissa = {crank_title(), {.low = 0, .high = 360, .turn = true}},
              .panels = {std::move(panel)},
              .each = 6.5});
  return {draw(f, folder)};
}

}  // namespace

const Drawing overlay{{"validation.json"}, draw_overlay};

}  // namespace freeplay::plots
