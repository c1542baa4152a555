// Relative influence (p/Q) dQ/dp of each key on each quantity, as bars.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "io/files/input_file.hpp"
#include "plots/drawing/figure.hpp"

namespace freeplay::plots {
namespace {

/// Bars beyond these numbers are too thin to read; the file has all.
constexpr std::size_t most_keys = 16, most_quantities = 8;
constexpr Word bar_colours[most_quantities] = {"C1", "C2", "C4", "C5", "C6", "C7", "C8", "C9"};

std::vector<std::filesystem::path> draw_sensitivity(const std::filesystem::path& folder) {
  const JsonFile document(folder / "sensitivity.json");
  const auto* quantities = document.find("quantities");
  const auto* keys = document.find("keys");
  if (!quantities || !quantities->is_array() || !keys || !keys->is_array())
    document.fail("quantities", "must be a list");
  const auto count = std::min(quantities->size(), most_quantities), rows = std::min(keys->size(), most_keys);
  if (count == 0 || rows == 0) return {};
  Figure f{.name = "sensitivity",
           .width_cm = 16,
           .height_cm = 3.4 + 0.32 * static_cast<double>(rows * (count + 1)),
           .source = "sensitivity.json"};
  Script ticks, plot;
  const double thickness = 0.8 / static_cast<double>(count);
  for (std::size_t k = 0; k < rows; ++k) {
    if (k > 0) ticks.add(", ");
    ticks.add_tic(document.text(fmt::format("keys.{}.name", k)), k);
  }
  for (std::size_t q = 0; q < count; ++q) {
    const auto at = fmt::format("quantities.{}", q);
    Block block(document.text(at + ".name") + ": place, relative influence, half thickness");
    const auto* influences = document.find(at + ".relative_influence");
    if (!influences || !influences->is_object())
      document.fail(at + ".relative_influence", "must be an object");
    for (std::size_t k = 0; k < rows; ++k) {
      const auto found = influences->find(document.text(fmt::format("keys.{}.name", k)));
      if (found == influences->end() || !found->is_number()) continue;
      const double place = static_cast<double>(k) - 0.4 + (static_cast<double>(q) + 0.5) * thickness;
      block.row({place, found->get<double>(), 0.45 * thickness});
    }
    if (block.empty()) continue;
    plot.add(
        "{}DATA index {} using ($2/2):1:(abs($2)/2):3 with boxxyerror fs solid 0.8 lc rgb {} title {} "
        "noenhanced",
        plot.empty() ? Word("plot ") : Word(", "), f.blocks.size(), bar_colours[q],
        document.text(at + ".name"));
    f.blocks.push_back(block);
  }
  if (plot.empty()) return {};
  f.script.add(
      "set xlabel 'Relative influence (p/Q) dQ/dp'\nset yrange [{}:-0.6]\nset ytics ({}) font SMALL "
      "noenhanced\n"
      "set arrow 1 from 0, graph 0 to 0, graph 1 nohead lc rgb 0x888888\n"
      // In columns of this height: gnuplot drops entries that do not fit its own choice.
      "set key outside top center vertical maxrows {} font SMALL\n{}\n",
      static_cast<double>(rows) - 0.4, ticks, (f.blocks.size() + 1) / 2, plot);
  return {draw(f, folder)};
}

}  // namespace

const Drawing sensitivity{{"sensitivity.json"}, draw_sensitivity};

}  // namespace freeplay::plots
