#include "plots/film/film_drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "io/scene/bearing_line.hpp"

namespace freeplay::report {
namespace {

constexpr std::array<std::string_view, 3> of_runs{"#0072b2", "#d55e00", "#6b7280"};
constexpr std::array<std::string_view, 7> of_bodies{"#0072b2", "#c8770a", "#008a68", "#b04a86",
                                                    "#a03f2a", "#2d7fa8", "#7a6a00"};
/// Drawing order, from back to front.
constexpr std::array<std::string_view, 15> order{"wall", "support", "outline", "line",    "disc",
                                                 "link", "spring",  "slider",  "weld",    "joint",
                                                 "pin",  "loose",   "bearing", "journal", "mass"};
constexpr double far = 4000;  // px, outside every panel

}  // namespace

std::string_view run_colour(std::size_t r) { return of_runs[std::min(r, of_runs.size() - 1)]; }
std::string_view ShapePainter::of(int body) const {
  if (!colour.empty()) return colour;
  return body < 0 ? soft : of_bodies[static_cast<std::size_t>(body) % of_bodies.size()];
}

Vec2 ShapePainter::place(const FilmShape& s) const {
  return pixel(run.pose(s.body, at).place(s.points.front()));
}

void ShapePainter::paint() const {
  for (const auto kind : order) {
    for (const auto& shape : run.shapes)
      if (shape.kind == kind) paint(shape);
    if (kind == "link")
      for (const auto& beam : run.beams) paint(beam);
  }
}

void ShapePainter::paint(const BeamLine& beam) const {
  auto points = run.line(beam, at, magnify);
  for (auto& p : points) p = pixel(p);
  svg.line(points, {.stroke = of(beam.points.front().bodies[1]), .width = 5, .opacity = opacity});
  name(points[points.size() / 2], beam.name);
}

/// Names stay within the panel; a letter is about half an em wide.
void ShapePainter::name(const Vec2& p, std::string_view words) const {
  const double room = width - 6.5 * static_cast<double>(std::min<std::size_t>(words.size(), 28));
  if (names)
    svg.text({std::min(p.x() + 7, std::max(0.0, room)), p.y() - 7}, words, 12, ink, Svg::Anchor::start, 28);
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
  } else if (is_surface(s.kind)) {
    auto points = run.line(s, at, magnify);
    for (auto& point : points) point = pixel(point);
    svg.line(points, {.stroke = s.kind == "bearing" ? accent : ink, .width = 1.5, .opacity = opacity}, true);
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
    name(p, s.name);
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

namespace {

// px
constexpr double top = 34, bottom = 36, beside = 190, clearance_height = 196, play_radius = 74;
// px
constexpr double longest_arrow = 90, longest_at_all = 160;

struct Box {
  double left = INFINITY, right = -INFINITY, low = INFINITY, high = -INFINITY;
  void hold(const Vec2& p, double r) {
    if (!std::isfinite(p.x() + p.y() + r)) return;
    left = std::min(left, p.x() - r), right = std::max(right, p.x() + r);
    low = std::min(low, p.y() - r), high = std::max(high, p.y() + r);
  }
};

/// Bounding box of the shapes of all runs over all frames, with a margin.
Box bounds(const std::vector<FilmRun>& runs, double magnify) {
  Box box;
  for (const auto& run : runs) {
    const auto each = std::max<std::size_t>(1, run.t.size() / 200);
    for (std::size_t i = 0; i < run.t.size(); i += each) {
      for (const auto& beam : run.beams)
        for (const auto& p : run.line(beam, {i, 0}, magnify)) box.hold(p, 0);
      for (const auto& s : run.shapes) {
        const auto pose = run.pose(s.body, {i, 0});
        const double r = s.kind == "disc" || s.kind == "loose" ? s.more.x() : 0;
        if (is_surface(s.kind))
          for (const auto& p : run.line(s, {i, 0}, magnify)) box.hold(p, 0);
        else
          for (const auto& p : s.points) box.hold(pose.place(p), r);
        if (s.kind == "spring" || s.kind == "line") box.hold(run.pose(s.other, {i, 0}).place(s.more), 0);
      }
    }
  }
  if (!std::isfinite(box.left)) box = {-1, 1, -1, 1};
  const double pad = 0.08 * std::max({box.right - box.left, box.high - box.low, 1e-9});
  return {box.left - pad, box.right + pad, box.low - pad, box.high + pad};
}

/// The greatest number ≤ x of the form 1, 2 or 5 times a power of ten.
double round_below(double x) {
  const double power = std::pow(10, std::floor(std::log10(x)));
  return power * (x >= 5 * power ? 5 : x >= 2 * power ? 2 : 1);
}

const FilmClearance* clearance_of_joint(const FilmRun& run, const std::string& name) {
  const auto it = std::ranges::find(run.clearance_joint, name, &FilmClearance::name);
  return it == run.clearance_joint.end() ? nullptr : &*it;
}

}  // namespace

FilmDrawing::FilmDrawing(const std::vector<FilmRun>& runs, FilmLook look)
    : runs_(runs), look_(std::move(look)) {
  std::set<std::string> seen;
  for (const auto& run : runs_)
    for (const auto& joint : run.clearance_joint)
      if (seen.insert(joint.name).second) names_.push_back(joint.name);
  const auto box = bounds(runs_, look_.magnify);
  middle_ = {0.5 * (box.left + box.right), 0.5 * (box.low + box.high)};
  const double count = look_.over ? 1.0 : static_cast<double>(runs_.size());
  const double room = look_.width - (names_.empty() ? 0 : beside), width = room / count;
  // The height follows the mechanism, within screen proportions, and at least the magnified joints
  // if there is room.
  const double shape = (box.high - box.low) / (box.right - box.left);
  const double most = 0.62 * look_.width, least = std::min(most, names_.empty() ? 220.0 : clearance_height);
  double height = std::clamp(shape * width, least, most);
  if (!names_.empty())
    height = std::max(
        height,
        std::min(clearance_height * static_cast<double>(std::min<std::size_t>(names_.size(), 3)), most));
  if (const auto fit = static_cast<std::size_t>(height / clearance_height); names_.size() > fit) {
    hidden_ = names_.size() - fit;
    names_.resize(fit);
  }
  scale_ = std::min(width / (box.right - box.left), height / (box.high - box.low));
  for (std::size_t r = 0; r < runs_.size(); ++r)
    if (r == 0 || !look_.over)
      panels_.push_back({{static_cast<double>(r) * width, top}, width, height, {r}});
    else
      panels_.front().runs.push_back(r);
  height_ = 2 * static_cast<int>(std::ceil(0.5 * (top + height + bottom)));
  look_.width += look_.width % 2;
}

Vec2 FilmDrawing::in_panel(const Vec2& p) const {
  const auto& panel = panels_.front();
  return {0.5 * panel.width + scale_ * (p.x() - middle_.x()),
          0.5 * panel.height - scale_ * (p.y() - middle_.y())};
}

Vec2 FilmDrawing::place(std::size_t r, const Vec2& point) const {
  return panels_[look_.over ? 0 : r].corner + in_panel(point);
}

Vec2 FilmDrawing::clearance_middle(std::size_t k) const {
  return {look_.width - 0.5 * beside, top + clearance_height * (static_cast<double>(k) + 0.5) - 12};
}

Vec2 FilmDrawing::journal(std::size_t r, std::size_t k, double t) const {
  const auto& run = runs_[r];
  const auto p = run.play(run.clearance_joint[k], run.at(t));
  return clearance_middle(k) + play_radius * Vec2{p[0], -p[1]};
}

void FilmDrawing::draw_mechanism(Svg& svg, const Panel& panel, double t, double reach) const {
  svg.open_panel(panel.corner, panel.width, panel.height);
  double usual = 0;
  for (const auto& run : runs_) usual = std::max(usual, run.usual_force);
  for (std::size_t k = 0; k < panel.runs.size(); ++k) {
    const auto r = panel.runs[k];
    const auto& run = runs_[r];
    const ShapePainter painter{svg,
                               run,
                               run.at(t),
                               [this](const Vec2& p) { return in_panel(p); },
                               scale_,
                               panel.runs.size() > 1 ? run_colour(r) : "",
                               k > 0 ? 0.65 : 1.0,
                               k == 0,
                               panel.width,
                               look_.magnify};
    painter.paint();
    for (const auto& force : run.forces) {
      if (force.shapes.empty() || usual == 0) continue;
      Vec2 by = (longest_arrow / usual) * Vec2{between(force.fx, painter.at), -between(force.fy, painter.at)};
      if (const double length = by.norm(); length > longest_at_all) by = (longest_at_all / length) * by;
      svg.arrow(in_panel(run.acts_at(force.shapes, painter.at)), by,
                {.stroke = force_colour, .width = 2, .opacity = painter.opacity});
    }
    // An impulse has no finite force; a ring marks it.
    for (auto e = std::ranges::lower_bound(run.events.list, t - reach, {}, &Event::t);
         e != run.events.list.end() && e->t <= t + reach; ++e) {
      if (run.events.kinds[static_cast<std::size_t>(e->kind)] == "separation") continue;
      if (const auto at = run.shapes_of(run.events.joints[e->joint]); !at.empty())
        svg.circle(in_panel(run.acts_at(at, painter.at)), 14, {.stroke = force_colour, .width = 2});
    }
  }
  draw_scale(svg, panel);
  if (look_.magnify != 1) {
    const auto any = [&](auto&& has) { return std::ranges::any_of(runs_, has); };
    svg.text({12, 16},
             magnified_words(look_.magnify, any([](const FilmRun& r) { return !r.beams.empty(); }),
                             any([](const FilmRun& r) { return r.has_surfaces(); })),
             12, soft);
  }
  svg.close_panel();
}

void FilmDrawing::draw_scale(Svg& svg, const Panel& panel) const {
  const double length = round_below(0.25 * panel.width / scale_);
  const double y = panel.height - 8;
  svg.line(std::array{Vec2{12, y}, Vec2{12 + length * scale_, y}}, {.stroke = soft, .width = 1.5});
  svg.text({12, y - 6}, length >= 1 ? fmt::format("{:g} m", length) : fmt::format("{:g} mm", 1e3 * length),
           12, soft);
}

void FilmDrawing::draw_loose(Svg& svg, std::size_t k, double t) const {
  const Vec2 middle = clearance_middle(k);
  const double edge = look_.width - beside;
  svg.open_panel({edge, middle.y() - 0.5 * clearance_height + 12}, beside, clearance_height);
  const Vec2 at{0.5 * beside, 0.5 * clearance_height - 12};
  const FilmClearance* any = nullptr;
  for (const auto& run : runs_)
    if (const auto* joint = clearance_of_joint(run, names_[k])) any = joint;
  const bool round = any->kind == "journal";
  if (round)
    svg.circle(at, play_radius, {.stroke = ink, .width = 1.5});
  else
    for (const double side : {-1.0, 1.0})
      svg.line(std::array{at + Vec2{-0.44 * beside, side * play_radius},
                          at + Vec2{0.44 * beside, side * play_radius}},
               {.stroke = ink, .width = 1.5});
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    const auto* joint = clearance_of_joint(runs_[r], names_[k]);
    if (!joint) continue;
    const auto now = runs_[r].at(t);
    const auto play = runs_[r].play(*joint, now);
    if (round) {
      const auto pixel = [&](const std::vector<double>& p) { return at + play_radius * Vec2{p[0], -p[1]}; };
      std::vector<Vec2> path;
      for (std::size_t i = now.i - std::min<std::size_t>(now.i, 200); i <= now.i; ++i)
        path.push_back(pixel(runs_[r].play(*joint, {i, 0})));
      path.push_back(pixel(play));
      svg.line(path, {.stroke = run_colour(r), .opacity = 0.55});
      svg.circle(path.back(), 5, {.fill = run_colour(r)});
    } else if (play.size() > 1) {
      const double reach = play_radius - 5;
      svg.line(
          std::array{at + Vec2{-0.3 * beside, -reach * play[0]}, at + Vec2{0.3 * beside, -reach * play[1]}},
          {.stroke = run_colour(r), .width = 6, .opacity = 0.75});
    } else {
      svg.circle(at + Vec2{0, -(play_radius - 7) * play[0]}, 7, {.fill = run_colour(r), .opacity = 0.75});
    }
  }
  svg.text({at.x(), clearance_height - 8}, fmt::format("{}, c = {:.3g} mm", names_[k], 1e3 * any->clearance),
           12, soft, Svg::Anchor::middle, 28);
  svg.close_panel();
}

std::string FilmDrawing::frame(double t, double reach) const {
  Svg svg(look_.width, height_);
  svg.text({12, 22}, look_.title, 15, ink, Svg::Anchor::start, static_cast<std::size_t>(look_.width / 14));
  for (const auto& panel : panels_) draw_mechanism(svg, panel, t, reach);
  for (std::size_t k = 0; k < names_.size(); ++k) draw_loose(svg, k, t);
  if (hidden_ > 0)
    svg.text({look_.width - 0.5 * beside, top - 6}, fmt::format("{} more joints with clearance", hidden_), 11,
             soft, Svg::Anchor::middle);
  // Runs by name and colour: under their panels, or beside one another.
  double x = 12;
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    const double left = look_.over ? x : panels_[r].corner.x() + 12;
    svg.circle({left + 5, height_ - 16.0}, 5, {.fill = run_colour(r)});
    svg.text({left + 16, height_ - 11.0}, runs_[r].title, 13, ink);
    x = left + 40 + 8 * static_cast<double>(runs_[r].title.size());
  }
  const auto& first = runs_.front();
  auto words = fmt::format("t = {:.4f} s", t);
  if (first.crank.first != first.crank.second) {
    const double angle = first.crank_angle(first.at(t)) * 180 / std::numbers::pi,
                 turns = std::floor(angle / 360);
    words += fmt::format("   crank {:.0f}°", angle - 360 * turns);
  }
  svg.text({look_.width - 215.0, height_ - 11.0}, words, 13, ink);
  return svg.finish();
}

}  // namespace freeplay::report
