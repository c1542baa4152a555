// Phase portraits of the bodies of a run after its transient: the rate of a coordinate over this
// coordinate. The coordinate is the angle, or x or y if the body rotates fully. A body that only
// rotates steadily is omitted.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "plots/drawing/figure.hpp"
#include "plots/tables/run_table.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t bodies_drawn = 9, across = 3;
constexpr long rows_drawn = 20'000;
constexpr double least_wide = 12;  ///< cm, for three portraits side by side

/// The coordinate to draw: 0 x, 1 y, 2 angle; −1 if none of them moves.
int coordinate_of(const std::array<std::vector<double>, 6>& m) {
  const auto moves = [&](std::size_t k) {
    const auto [least, most] = std::ranges::minmax(m[k]);
    return most - least > 1e-6 * std::max({std::abs(least), std::abs(most), 1e-6});
  };
  if (range_of(m[2]) < 2 * std::numbers::pi && moves(2) && moves(5)) return 2;
  const std::size_t k = range_of(m[3]) >= range_of(m[4]) ? 0 : 1;
  return moves(k) && moves(3 + k) ? static_cast<int>(k) : -1;
}

std::vector<std::filesystem::path> draw_phase_portrait(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / "comparison.json") || runs_in(folder).empty()) return {};
  const double end = end_of(folder), discard = discard_of(folder);
  const Span span{discard < end ? discard : 0, end, ""};
  const auto table = motion_of(folder, span, bodies_drawn, rows_drawn);
  if (table.t.size() < 3) return {};
  struct Panel {
    std::size_t body, coordinate;
  };
  std::vector<Panel> panels;
  for (std::size_t b = 0; b < table.bodies.size(); ++b)
    if (const int k = coordinate_of(table.motion[b]); k >= 0)
      panels.push_back({b, static_cast<std::size_t>(k)});
  if (panels.empty()) return {};

  const auto style = style_of(folder);
  const bool wide = !style.width || *style.width > 10 * least_wide;
  const auto columns = std::min(wide ? across : across - 1, panels.size()),
             rows = (panels.size() + columns - 1) / columns;
  Figure f{.name = "phase_portrait",
           .width_cm = columns == 1 ? 9.0 : 16.0,
           .height_cm = 1.1 + 5.6 * static_cast<double>(rows),
           .source = "run.json"};
  f.script.add(
      "set multiplot layout {},{} margins X(1.8),1-X(0.4),Y(1.5),1-Y(1.3) spacing X(1.75),Y(1.9)\nunset key\nset tics font SMALL\n"
      "set xtics autofreq\nset label 1 {} at screen X(0.25),1-Y(0.3) font SMALL tc rgb 0x555555 noenhanced\nset title offset 0,-0.7\n",
      rows, columns, fmt::format("{:.4g} to {:.4g} s", span.from, span.to));
  const Word places[] = {"x (m)", "y (m)", Word("θ (rad)", "$\\theta$ (rad)")};
  const Word rates[] = {Word("v_x (m/s)", "$v_x$ (m/s)"), Word("v_y (m/s)", "$v_y$ (m/s)"),
                        Word("ω (rad/s)", "$\\omega$ (rad/s)")};
  for (std::size_t p = 0; p < panels.size(); ++p) {
    const auto& [body, k] = panels[p];
    const auto &q = table.motion[body][k], &v = table.motion[body][3 + k];
    Block block(fmt::format("{}: {}, {}", table.bodies[body], places[k].text(), rates[k].text()));
    for (std::size_t i = 0; i < q.size(); ++i) block.row({q[i], v[i]});
    const auto [least, most] = std::ranges::minmax(q);
    const double margin = 0.05 * (most - least);
    f.script.add(
        "set xrange [{:.8g}:{:.8g}]\nset xtics {:.6g}\nset title {} noenhanced\nset xlabel '{}'\nset ylabel '{}'\n"
        "plot DATA index {} using 1:2 with lines lw 0.8 lc rgb C{}\n{}",
        least - margin, most + margin, tic_step(most - least, !wide), table.bodies[body], places[k], rates[k],
        p, 1 + body, p == 0 ? Word("unset label 1\nunset label 100\n") : Word(""));
    f.blocks.push_back(std::move(block));
  }
  f.script.add("unset multiplot\n");
  return {draw(f, folder)};
}

}  // namespace

const Drawing phase_portrait{{"run.json"}, draw_phase_portrait};

}  // namespace freeplay::plots
