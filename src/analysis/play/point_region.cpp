#include "analysis/play/point_region.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/play/play_documents.hpp"

namespace freeplay {
namespace {

constexpr int directions = 72;
constexpr std::size_t most_positions = 4;

/// The positions at which the region of a point with the coordinates x and y is computed, in increasing order.
std::vector<std::size_t> chosen_positions(const Play& play, std::size_t x, std::size_t y) {
  std::vector<std::size_t> known, chosen;
  std::size_t widest = 0;
  const auto width = [&](std::size_t i) {
    const auto& ranges = play.positions[known[i]].ranges;
    return std::hypot(ranges[x].width(), ranges[y].width());
  };
  for (std::size_t i = 0; i < play.positions.size(); ++i) {
    if (!play.positions[i].refusal.empty()) continue;
    known.push_back(i);
    // Both ends of a full turn have the same width within rounding; the first one counts.
    constexpr double more = 1 + 1e-9;
    if (width(known.size() - 1) > more * width(widest)) widest = known.size() - 1;
  }
  const auto count = std::min(most_positions, known.size());
  for (std::size_t j = 0; j < count; ++j)
    chosen.push_back(known[(widest + j * known.size() / count) % known.size()]);
  std::ranges::sort(chosen);
  return chosen;
}

}  // namespace

void add_regions(LooseMechanism& mechanism, PlayExtremes& extremes, Play& play, const StopToken& stop) {
  using Kind = PlayOutput::Kind;
  const auto point_of = [](const PlayOutput& quantity) {
    return quantity.name.substr(0, quantity.name.rfind('.'));
  };
  for (std::size_t x = 0; x < play.quantities.size(); ++x) {
    if (play.quantities[x].kind != Kind::x) continue;
    const auto point = point_of(play.quantities[x]);
    const auto other = std::ranges::find_if(
        play.quantities, [&](const auto& q) { return q.kind == Kind::y && point_of(q) == point; });
    if (other == play.quantities.end()) continue;
    const auto y = static_cast<std::size_t>(other - play.quantities.begin());
    for (const auto i : chosen_positions(play, x, y)) {
      if (stop()) throw Interrupted();
      const auto& at = play.positions[i];
      extremes.enclose(Eigen::Map<const Eigen::VectorXd>(at.pose.data(), mechanism.n()), at.coordinate);
      PointRegion region{point, i, at.ranges[x].ideal, at.ranges[y].ideal, {}};
      // Rounding of the sum of both coordinates, in which they may cancel.
      const double rounding =
          8 * std::numeric_limits<double>::epsilon() * (std::abs(region.ideal_x) + std::abs(region.ideal_y));
      Eigen::VectorXd u;
      for (int d = 0; d < directions; ++d) {
        const double phi = 2 * std::numbers::pi * d / directions;
        mechanism.combine(static_cast<int>(x), static_cast<int>(y), phi);
        const auto most = extremes.greatest(LooseMechanism::combined, 1, u);
        u = most.u;
        region.farthest.push_back(
            {phi, extremes.value(static_cast<int>(x), u).value_or(NAN),
             extremes.value(static_cast<int>(y), u).value_or(NAN),
             most.bound - std::cos(phi) * region.ideal_x - std::sin(phi) * region.ideal_y + rounding});
      }
      play.regions.push_back(std::move(region));
    }
  }
}

Table play_region_table(const Play& play) {
  Table table({"at", "point", "ideal_x", "ideal_y", "phi", "x", "y", "bound"});
  for (const auto& r : play.regions)
    for (const auto& b : r.farthest)
      table.row(std::vector<Table::Cell>{play.positions[r.position].coordinate, r.point, r.ideal_x, r.ideal_y,
                                         b.direction, b.x, b.y,
                                         std::isfinite(b.bound) ? Table::cell(b.bound) : Table::cell("")});
  return table;
}

}  // namespace freeplay
