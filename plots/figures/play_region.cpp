// Reachable regions of points within the clearances: the pose of the mechanism, and the region of the point at
// some positions of the driven joint, magnified about its ideal place p by a round factor M,
//
//     p + M (x − p),
//
// with which the greatest region is about a tenth of the picture. The pose is that of the greatest region; those of
// the others are grey.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "io/files/input_file.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/figures/pose.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

/// A row of play_region.csv: the farthest place along φ, relative to the ideal one, and the bound.
struct Farthest {
  double phi, x, y, bound;
};

struct Region {
  double at, x, y;  ///< driven coordinate; ideal place
  std::vector<Farthest> edge;
  double size() const {
    double most = 0;
    for (const auto& e : edge) most = std::max(most, std::hypot(e.x, e.y));
    return most;
  }
  /// Greatest distance of a bound from the place found; infinite if a direction has none.
  double gap() const {
    double most = 0;
    for (const auto& e : edge) {
      const double gap = e.bound - (std::cos(e.phi) * e.x + std::sin(e.phi) * e.y);
      most = std::isnan(gap) ? INFINITY : std::max(most, gap);
    }
    return most;
  }
};

struct Point {
  std::string name;
  std::vector<Region> regions;
};

std::vector<Point> points_in(const std::filesystem::path& file) {
  Rows rows(file);
  const auto at = rows.place("at"), point = rows.place("point"), ideal_x = rows.place("ideal_x"),
             ideal_y = rows.place("ideal_y"), phi = rows.place("phi"), x = rows.place("x"),
             y = rows.place("y"), bound = rows.place("bound");
  std::vector<Point> list;
  while (rows.next()) {
    if (list.empty() || list.back().name != rows.name(point)) list.push_back({rows.name(point), {}});
    auto& regions = list.back().regions;
    if (regions.empty() || regions.back().at != rows.number(at))
      regions.push_back({rows.number(at), rows.number(ideal_x), rows.number(ideal_y), {}});
    auto& r = regions.back();
    r.edge.push_back(
        {rows.number(phi), rows.number(x) - r.x, rows.number(y) - r.y, rows.maybe_number(bound)});
  }
  return list;
}

/// The outline of a region magnified M times.
Block outline(const Region& r, double factor) {
  Block block("region");
  for (std::size_t i = 0; i <= r.edge.size(); ++i) {
    const auto& e = r.edge[i % r.edge.size()];
    block.row({r.x + factor * e.x, r.y + factor * e.y});
  }
  return block;
}

/// The polygon of the lines cos φ x + sin φ y = bound, magnified M times.
Block outer_bound(const Region& r, double factor) {
  Block block("bound");
  for (std::size_t i = 0; i <= r.edge.size(); ++i) {
    const auto &a = r.edge[i % r.edge.size()], &b = r.edge[(i + 1) % r.edge.size()];
    const double across = factor / std::sin(b.phi - a.phi);
    block.row({r.x + across * (a.bound * std::sin(b.phi) - b.bound * std::sin(a.phi)),
               r.y + across * (b.bound * std::cos(a.phi) - a.bound * std::cos(b.phi))});
  }
  return block;
}

Block ideal_path(const std::filesystem::path& folder, const std::string& point) {
  Rows rows(folder / "play.csv");
  const auto x = rows.place(point + ".x.ideal"), y = rows.place(point + ".y.ideal");
  Block block("ideal path");
  while (rows.next())
    if (const double place = rows.maybe_number(x); std::isnan(place))
      block.gap();
    else
      block.row({place, rows.number(y)});
  return block;
}

std::filesystem::path draw_point(const std::filesystem::path& folder, const Point& point,
                                 const std::vector<std::pair<double, Shape>>& all, bool turns) {
  const auto& main = *std::ranges::max_element(point.regions, {}, &Region::size);
  const auto pose_at = [&](double at) {
    std::vector<Shape> shapes;
    for (const auto& [place, shape] : all)
      if (place == at) shapes.push_back(shape);
    return shapes;
  };
  Frame frame;
  for (const auto& r : point.regions) {
    const auto one = frame_of(pose_at(r.at));
    frame.hold(one.left, one.low, 0), frame.hold(one.right, one.high, 0);
  }
  const double factor = round_factor(0.1 * frame.size() / (2 * main.size()));
  for (const auto& r : point.regions) frame.hold(r.x, r.y, 1.5 * factor * main.size());
  const double u = 0.02 * frame.size();

  Figure f{.name = file_name("play_region", point.name), .source = "play.json"};
  f.caption = fmt::format(
      "Reachable region of {} within the clearances, magnified {:.0f} times about its ideal "
      "place, and the pose of the greatest region; other poses are grey.",
      point.name, factor);
  Panel panel{
      .title = AxisTitle::of("y", "m"), .axis = {frame.low - 3 * u, frame.high + 3 * u}, .curves = {}};
  const auto unit = turns ? ShownUnit{"°", std::numbers::pi / 180} : fitting_unit("m", std::abs(main.at));
  for (const auto& r : point.regions) {
    if (r.at == main.at) continue;
    auto links = pose_at(r.at);
    std::erase_if(links, [](const Shape& s) { return s.kind != "link" && s.kind != "beam"; });
    for (auto& curve : pose_curves(links, u, 0))
      add_curve(f, panel, std::move(curve.block), Script().add("using 1:2 with lines lw 1 lc rgb '#b0b0b0'"));
  }
  for (auto& curve : pose_curves(pose_at(main.at), u, 0.8 * frame.size()))
    add_curve(f, panel, std::move(curve.block), Script().add("using 1:2 {}", curve.style));
  if (point.regions.size() > 1)
    add_curve(f, panel, ideal_path(folder, point.name), Script().add("using 1:2 with lines lw 0.8 lc rgb C3"),
              "ideal path");
  constexpr double visible_gap = 0.02;  // share of the size of the region
  std::string title = fmt::format("region × {:.0f}", factor), bound_title = "bound";
  for (const auto& r : point.regions) {
    const Script drawn = Script().add("DATA index {} using 1:2 with ", f.blocks.size());
    add_curve(f, panel, outline(r, factor),
              Script().add("using 1:2 with filledcurves closed fs transparent solid 0.35 noborder lc rgb C9"),
              std::exchange(title, ""));
    panel.curves.push_back({Script().add("{}lines lw 1.2 lc rgb C9", drawn), ""});
    if (const double gap = r.gap(); std::isfinite(gap) && gap > visible_gap * r.size())
      add_curve(f, panel, outer_bound(r, factor),
                Script().add("using 1:2 with lines lw 1 dt (2,3) lc rgb C3"), std::exchange(bound_title, ""));
    if (point.regions.size() == 1) continue;
    const auto& top = *std::ranges::max_element(r.edge, {}, &Farthest::y);
    panel.before.add("set label {} at {},{} center offset 0,0.7 font SMALL noenhanced front\n",
                     turns ? fmt::format("{:.4g}°", r.at / unit.size)
                           : fmt::format("{:.4g} {}", r.at / unit.size, unit.name),
                     r.x, r.y + factor * top.y);
  }
  return draw_panels(f, folder,
                     {.abscissa = {AxisTitle::of("x", "m"), {frame.left - 3 * u, frame.right + 3 * u}},
                      .panels = {std::move(panel)},
                      .equal_scales = true});
}

std::vector<std::filesystem::path> draw_regions(const std::filesystem::path& folder) {
  const bool turns = JsonFile(folder / "play.json").text("unit") == "rad";
  const auto file = folder / "play_pose.csv";
  const auto at = ReadTable(file, {}, {"at"}).column("at");
  const auto shapes = shapes_in(file);
  std::vector<std::pair<double, Shape>> all;
  for (std::size_t i = 0; i < shapes.size(); ++i) all.emplace_back(at[i], shapes[i]);
  std::vector<std::filesystem::path> made;
  for (const auto& point : points_in(folder / "play_region.csv")) {
    const auto& r = point.regions.front();
    constexpr double rounding = 1e-12;
    const bool has_play = std::ranges::any_of(
        point.regions, [&](const Region& region) { return region.size() > rounding * std::hypot(r.x, r.y); });
    if (has_play) made.push_back(draw_point(folder, point, all, turns));
  }
  return made;
}

}  // namespace

const Drawing play_region{{"play_region.csv"}, draw_regions};

}  // namespace freeplay::plots
