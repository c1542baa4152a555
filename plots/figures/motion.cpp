// The motion of the bodies of a run over time: positions of the centres of mass, and angles, or, if
// a body rotates fully, angular velocities.
#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "plots/drawing/figure.hpp"
#include "plots/tables/run_table.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t most_bodies = 9;
constexpr long most_rows = 4000;
constexpr Word dashes[] = {"1", "(12,5)", "(3,4)", "(14,4,3,4)"};

std::vector<std::filesystem::path> draw_motion(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / "comparison.json") || runs_in(folder).empty()) return {};
  const auto scene = scene_of_run(folder);
  const double end = end_of(folder);
  const auto turn = turn_of(scene.get());
  const Span span = turn && end > 5 * *turn ? last_part(turn, end, 2) : Span{0, end, "whole run"};
  const auto table = motion_of(folder, span, most_bodies, most_rows);
  if (table.t.size() < 2 || table.bodies.empty()) return {};
  const bool round = std::ranges::any_of(
      table.motion, [](const auto& body) { return range_of(body[2]) > 2 * std::numbers::pi; });

  Figure f{.name = "motion", .height_cm = 13.4, .source = "run.json"};
  for (std::size_t b = 0; b < table.bodies.size(); ++b) {
    Block block(
        fmt::format("{}: t (s), x (m), y (m), {}", table.bodies[b], round ? "omega (rad/s)" : "theta (rad)"));
    const auto& m = table.motion[b];
    for (std::size_t i = 0; i < table.t.size(); ++i)
      block.row({table.t[i], m[0][i], m[1][i], round ? m[5][i] : m[2][i]});
    f.blocks.push_back(std::move(block));
  }
  f.script.add(
      "set multiplot layout 3,1 margins X(1.9),1-X(0.5),Y(1.5),1-Y(1.3) spacing 0,Y(0.5)\n"
      "set key at screen 1-X(0.5),1-Y(0.15) right top horizontal maxrows 2 samplen 2 font SMALL\nset format x ''\n"
      "set xrange [{:.8g}:{:.8g}]\n",
      table.t.front(), std::max(table.t.back(), span.to));  // thinning may omit the last row
  const Word quantities[] = {
      "x (m)", "y (m)", round ? Word("ω (rad/s)", "$\\omega$ (rad/s)") : Word("θ (rad)", "$\\theta$ (rad)")};
  for (int panel = 0; panel < 3; ++panel) {
    if (panel == 2) f.script.add("set format x\nset xlabel {}\n", "Time (s): " + span.name);
    f.script.add("set ylabel '{}'\n", quantities[panel]);
    for (std::size_t b = 0; b < table.bodies.size(); ++b)
      f.script.add("{}DATA index {} using 1:{} with lines lw 1.2 lc rgb C{} dt {} title {} noenhanced",
                   b ? Word(", ") : Word("plot "), b, panel + 2, 1 + b, dashes[b % std::size(dashes)],
                   table.bodies[b]);
    f.script.add("\n{}", panel == 0 ? Word("unset key\nunset label 100\n") : Word(""));
  }
  f.script.add("unset multiplot\n");
  return {draw(f, folder)};
}

}  // namespace

const Drawing motion{{"run.json"}, draw_motion};

}  // namespace freeplay::plots
