// The motion of the bodies of a run over time: positions of the centres of mass, and angles, or, if
// a body rotates fully, angular velocities.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/run_facts.hpp"

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
  const auto motion = motion_of(folder, span, most_bodies, most_rows);
  if (motion.t.size() < 2 || motion.bodies.empty()) return {};
  const bool round = std::ranges::any_of(
      motion.coordinates, [](const auto& body) { return range_of(body[2]) > 2 * std::numbers::pi; });

  Figure f{.name = "motion", .source = "run.json"};
  if (span.name != "whole run") f.caption = fmt::format("Motion of the bodies: {}.", span.name);
  const std::size_t columns[] = {0, 1, round ? std::size_t{5} : std::size_t{2}};
  const AxisTitle titles[] = {
      AxisTitle::of("x", "m"), AxisTitle::of("y", "m"),
      round ? AxisTitle::of({"ω", "$\\omega$"}, "rad/s") : AxisTitle::of({"θ", "$\\theta$"}, "rad")};
  for (std::size_t b = 0; b < motion.bodies.size(); ++b) {
    Block block(fmt::format("{}: t (s), x (m), y (m), {}", motion.bodies[b],
                            round ? "omega (rad/s)" : "theta (rad)"));
    const auto& m = motion.coordinates[b];
    for (std::size_t i = 0; i < motion.t.size(); ++i)
      block.row({motion.t[i], m[0][i], m[1][i], m[columns[2]][i]});
    f.blocks.push_back(std::move(block));
  }
  PanelStack stack{.abscissa = {time_title(), {motion.t.front(), std::max(motion.t.back(), span.to)}},
                   .panels = {},
                   .each = 3.2};
  double extent[] = {0, 0, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    Panel panel{.title = titles[k], .axis = {}, .curves = {}};
    double least = INFINITY, most = -INFINITY;
    for (std::size_t b = 0; b < motion.bodies.size(); ++b) {
      const auto [low, high] = std::ranges::minmax(motion.coordinates[b][columns[k]]);
      least = std::min(least, low), most = std::max(most, high);
      panel.curves.push_back({Script().add("DATA index {} using 1:{} with lines lw 1.2 lc rgb C{} dt {}", b,
                                           k + 2, 1 + b, dashes[b % std::size(dashes)]),
                              k == 0 ? motion.bodies[b] : ""});
    }
    panel.axis = axis_of(least, most);
    extent[k] = most - least;
    stack.panels.push_back(std::move(panel));
  }
  // A motion along one axis leaves the other coordinate constant: a range small beside the motion.
  for (const std::size_t k : {0u, 1u}) {
    const double other = extent[1 - k];
    if (!(extent[k] <= 1e-9 * other) || other <= 0) continue;
    auto& axis = stack.panels[k].axis;
    const double middle = 0.5 * (axis.low + axis.high);
    axis.low = middle - 0.1 * other, axis.high = middle + 0.1 * other;
  }
  return {draw_panels(f, folder, std::move(stack))};
}

}  // namespace

const Drawing motion{{"run.json"}, draw_motion};

}  // namespace freeplay::plots
