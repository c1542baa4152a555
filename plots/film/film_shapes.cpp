#include "plots/film/film_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace freeplay::report {
namespace {

constexpr std::array<std::string_view, 3> of_runs{"#0072b2", "#d55e00", "#6b7280"};
constexpr std::array<std::string_view, 7> of_bodies{"#0072b2", "#c8770a", "#008a68", "#b04a86",
                                                    "#a03f2a", "#2d7fa8", "#7a6a00"};
/// Drawing order, from back to front.
constexpr std::array<std::string_view, 13> order{"wall", "support", "outline", "line", "disc",
                                                 "link", "spring",  "slider",  "weld", "joint",
                                                 "pin",  "loose",   "mass"};
constexpr double far = 4000;  // px, outside every panel

}  // namespace

std::string_view run_colour(std::size_t r) { return of_runs[std::min(r, of_runs.size() - 1)]; }
std::string_view body_colour(int body) {
  return body < 0 ? soft : of_bodies[static_cast<std::size_t>(body) % of_bodies.size()];
}

std::string_view ShapePainter::of(int body) const { return colour.empty() ? body_colour(body) : colour; }

Vec2 ShapePainter::place(const FilmShape& s) const {
  return pixel(run.pose(s.body, at).place(s.points.front()));
}

void ShapePainter::paint() const {
  for (const auto kind : order)
    for (const auto& shape : run.shapes)
      if (shape.kind == kind) paint(shape);
}

void ShapePainter::hatch(const Vec2& middle, const Vec2& along, double length, double size) const {
  const Vec2 back{-0.5 * size * (along.x() + along.y()), -0.5 * size * (along.y() - along.x())};
  const int strokes = std::clamp(static_cast<int>(length / (0.8 * size)), 4, 60);
  for (int i = 0; i <= strokes; ++i) {
    const Vec2 p = middle + (length * (static_cast<double>(i) / strokes - 0.5)) * along;
    svg.line(std::array{p, p + back}, {.stroke = soft, .opacity = opacity});
  }
}

void ShapePainter::paint(const FilmShape& s) const {
  const auto pose = run.pose(s.body, at);
  const Vec2 p = place(s);
  const auto ring = [&](double r, std::string_view stroke, bool dashed = false) {
    svg.circle(p, r,
               {.stroke = stroke,
                .width = 1.8,
                .fill = r < 6 ? "#ffffff" : "none",
                .opacity = opacity,
                .dashed = dashed});
  };
  if (s.kind == "link" || s.kind == "outline") {
    std::vector<Vec2> corners;
    for (const auto& corner : s.points) corners.push_back(pixel(pose.place(corner)));
    const bool link = s.kind == "link";
    if (link && corners.size() > 3) svg.line(corners, {.fill = of(s.body), .opacity = 0.15 * opacity});
    svg.line(corners, {.stroke = of(s.body), .width = link ? 5.0 : 2.0, .opacity = opacity}, !link);
  } else if (s.kind == "disc") {
    const double r = std::max(2.0, s.more.x() * scale);
    svg.circle(p, r, {.stroke = of(s.body), .width = 1.5, .opacity = opacity});
    svg.line(std::array{p, p + r * Vec2{pose.cosine, -pose.sine}},
             {.stroke = of(s.body), .width = 1.5, .opacity = opacity});
  } else if (s.kind == "line") {
    svg.line(std::array{p, pixel(run.pose(s.other, at).place(s.more))},
             {.stroke = of(s.body), .width = 2, .opacity = opacity});
  } else if (s.kind == "wall") {
    const Vec2 u = run.pose(s.other, at).turned(s.more), along{u.x(), -u.y()};
    svg.line(std::array{p - far * along, p + far * along},
             {.stroke = soft, .width = 1.5, .opacity = opacity});
    hatch(p, along, 600, 12);
  } else if (s.kind == "slider") {
    paint_slider(s);
  } else if (s.kind == "spring") {
    paint_spring(s);
  } else if (s.kind == "support") {
    svg.line(std::array{p, p + Vec2{-8, 14}, p + Vec2{8, 14}},
             {.stroke = soft, .width = 1.2, .opacity = opacity}, true);
    hatch(p + Vec2{0, 14}, {1, 0}, 24, 7);
  } else if (s.kind == "pin") {
    ring(5, ink);
  } else if (s.kind == "loose") {
    ring(std::max(7.0, s.more.x() * scale), accent, true);
    ring(2.5, ink);
  } else if (s.kind == "joint") {
    ring(3, ink);
  } else if (s.kind == "weld") {
    svg.line(std::array{p + Vec2{-4, -4}, p + Vec2{4, -4}, p + Vec2{4, 4}, p + Vec2{-4, 4}},
             {.fill = ink, .opacity = opacity}, true);
  } else if (s.kind == "mass") {
    svg.circle(p, 2.5, {.fill = of(s.body), .opacity = opacity});
    // A letter is about half an em wide; names stay within the panel.
    const double room = width - 6.5 * static_cast<double>(std::min<std::size_t>(s.name.size(), 28));
    if (names)
      svg.text({std::min(p.x() + 7, std::max(0.0, room)), p.y() - 7}, s.name, 12, ink, Svg::Anchor::start,
               28);
  }
}

void ShapePainter::paint_slider(const FilmShape& s) const {
  const Vec2 p = place(s), u = run.pose(s.other, at).turned(s.more);
  const auto beside = [&](double along, double across) {
    return p + Vec2{along * u.x() - across * u.y(), -along * u.y() - across * u.x()};
  };
  for (const double side : {-10.0, 10.0})
    svg.line(std::array{beside(-42, side), beside(42, side)}, {.stroke = soft, .opacity = opacity});
  svg.line(std::array{beside(-16, -9), beside(16, -9), beside(16, 9), beside(-16, 9)},
           {.stroke = of(s.body), .width = 2.5, .fill = "#ffffff", .opacity = opacity}, true);
}

void ShapePainter::paint_spring(const FilmShape& s) const {
  const Vec2 from = place(s), to = pixel(run.pose(s.other, at).place(s.more)), d = to - from;
  const double length = std::max(d.norm(), 1e-9);
  const Vec2 n{-d.y() / length, d.x() / length};
  std::vector<Vec2> points;
  for (int i = 0; i <= 16; ++i) {
    const double across = i < 2 || i > 14 ? 0 : i % 2 != 0 ? 6 : -6;
    points.push_back(from + (i / 16.0) * d + across * n);
  }
  svg.line(points, {.stroke = soft, .width = 1.5, .opacity = opacity});
}

}  // namespace freeplay::report
