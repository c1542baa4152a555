#include "plots/film/wear_drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mechanism/error.hpp"
#include "plots/film/film_drawing.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::report {
namespace {

constexpr double nominal_share = 0.32;  // radius of the nominal circle over the size of a cell
constexpr double depth_share = 0.12;    // greatest depth, likewise
constexpr int foot = 40;                // px, below the cells
constexpr int most_cells = 64;

}  // namespace

WearDrawing::WearDrawing(const std::filesystem::path& folder, int width) : width_(width), height_(0) {
  const plots::ReadTable table(folder / "profiles.csv", {"formulation", "joint"},
                               {"turns", "bearing_depth", "journal_depth"});
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const auto &formulation = table.text("formulation")[i], &joint = table.text("joint")[i];
    if (cells_.empty() || cells_.back().formulation != formulation || cells_.back().joint != joint)
      cells_.push_back({joint, formulation, {}});
    auto& list = cells_.back().snapshots;
    const double turns = table.column("turns")[i];
    if (list.empty() || list.back().turns != turns) list.push_back({turns, {}, {}});
    const double b = table.column("bearing_depth")[i], j = table.column("journal_depth")[i];
    list.back().bearing.push_back(b), list.back().journal.push_back(j);
    turns_ = std::max(turns_, turns), greatest_ = std::max({greatest_, b, j});
    plots::place_in(joints_, joint), plots::place_in(formulations_, formulation);
  }
  for (const auto& cell : cells_)
    for (const auto& s : cell.snapshots)
      if (s.bearing.size() != cell.snapshots.front().bearing.size())
        throw SceneError((folder / "profiles.csv").string() + ": must have the same angles in each cycle");
  if (!(greatest_ > 0) || cells_.size() > most_cells)
    throw SceneError(folder.string() + ": has no wear to animate, or too many joints");
  const auto side = width_ / static_cast<int>(formulations_.size());
  height_ = (side * static_cast<int>(joints_.size()) + foot) / 2 * 2;
}

WearDrawing::Snapshot WearDrawing::at(const Cell& cell, double turns) const {
  const auto& list = cell.snapshots;
  std::size_t i = 1;
  while (i < list.size() && list[i].turns < turns) ++i;
  if (i >= list.size()) return list.back();
  const auto &a = list[i - 1], &b = list[i];
  const double share = std::clamp((turns - a.turns) / (b.turns - a.turns), 0.0, 1.0);
  Snapshot s{turns, a.bearing, a.journal};
  for (std::size_t k = 0; k < s.bearing.size(); ++k) {
    s.bearing[k] = std::lerp(a.bearing[k], b.bearing[k], share);
    s.journal[k] = std::lerp(a.journal[k], b.journal[k], share);
  }
  return s;
}

std::string WearDrawing::frame(double turns) const {
  Svg svg(width_, height_);
  const double side = static_cast<double>(width_) / static_cast<double>(formulations_.size());
  const double radius = nominal_share * side;
  const double scale = depth_share * side / greatest_;
  for (const auto& cell : cells_) {
    const auto column = std::ranges::find(formulations_, cell.formulation) - formulations_.begin();
    const auto row = std::ranges::find(joints_, cell.joint) - joints_.begin();
    const Vec2 middle{(static_cast<double>(column) + 0.5) * side, (static_cast<double>(row) + 0.5) * side};
    const auto now = at(cell, turns);
    const auto outline = [&](const std::vector<double>& depth, double sign, std::string_view colour) {
      std::vector<Vec2> points;
      for (std::size_t k = 0; k < depth.size(); ++k) {
        const double angle =
            2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(depth.size());
        const double r = radius + sign * scale * depth[k];
        points.push_back(middle + Vec2{r * std::cos(angle), -r * std::sin(angle)});
      }
      svg.line(points, {.stroke = colour, .width = 2}, true);
    };
    svg.circle(middle, radius, {.stroke = soft, .width = 0.8, .dashed = true});
    outline(now.bearing, 1, run_colour(0));
    outline(now.journal, -1, run_colour(1));
    svg.text(middle, fmt::format("{}: {}", cell.joint, cell.formulation), 16, ink, Svg::Anchor::middle);
    svg.text(middle + Vec2{0, 24},
             fmt::format("{:.3g} um", 1e6 * std::max(*std::ranges::max_element(now.bearing),
                                                     *std::ranges::max_element(now.journal))),
             14, soft, Svg::Anchor::middle);
  }
  svg.text({0.5 * width_, static_cast<double>(height_) - 0.4 * foot}, fmt::format("{:.3g} turns", turns), 18,
           ink, Svg::Anchor::middle);
  return svg.finish();
}

}  // namespace freeplay::report
