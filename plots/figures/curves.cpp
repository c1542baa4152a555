// Curves of bifurcations over two keys: the first key along the abscissa, the second one along the ordinate.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "io/files/input_file.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/drawing/style.hpp"
#include "plots/figures/bifurcation_looks.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

std::vector<std::filesystem::path> draw_curves(const std::filesystem::path& folder) {
  const JsonFile document(folder / "continue.json");
  const double scale = document.number("continue.scale"),
               second_scale = document.number("continue.second.scale");
  std::array<std::vector<Block>, std::size(bifurcation_looks)> blocks;
  Limits across, up;
  Rows rows(folder / "curves.csv");
  const auto curve = rows.place("curve"), kind = rows.place("kind"), x = rows.place("parameter"),
             y = rows.place("second");
  std::string last;
  while (rows.next()) {
    const auto of =
        std::ranges::find_if(bifurcation_looks, [&](const auto& k) { return rows.name(kind) == k.kind; });
    if (of == std::end(bifurcation_looks)) continue;
    auto& list = blocks[static_cast<std::size_t>(of - bifurcation_looks)];
    if (list.empty()) list.emplace_back(std::string(of->title) + ": first key, second key");
    if (rows.name(curve) != last) list.front().gap();
    last = rows.name(curve);
    const double px = scale * rows.number(x), py = second_scale * rows.number(y);
    list.front().row({px, py});
    across.hold(px);
    up.hold(py);
  }
  if (!(across.range() > 0)) return {};
  Figure f{.name = "curves", .height_cm = 10, .source = "continue.json"};
  Panel panel{
      .title = AxisTitle::plain(document.text("continue.second.key"), document.text("continue.second.unit")),
      .axis = axis_of(up.least, up.most),
      .curves = {}};
  for (std::size_t i = 0; i < blocks.size(); ++i)
    if (!blocks[i].empty())
      add_curve(f, panel, std::move(blocks[i].front()),
                Script().add("using 1:2 with lines {}", bifurcation_looks[i].line),
                bifurcation_looks[i].title);
  const double margin = 0.02 * across.range();
  add_panels(f, style_of(folder),
             {.abscissa = {AxisTitle::plain(document.text("continue.key"), document.text("continue.unit")),
                           {across.least - margin, across.most + margin}},
              .panels = {std::move(panel)},
              .each = 7.5});
  return {draw(f, folder)};
}

}  // namespace

const Drawing curves{{"curves.csv"}, draw_curves};

}  // namespace freeplay::plots
