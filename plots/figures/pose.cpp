#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/files/input_file.hpp"
#include "io/scene/beam_line.hpp"
#include "io/scene/bearing_line.hpp"
#include "plots/drawing/axis.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/style.hpp"
#include "plots/figures/pose.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {

// The pose in which a mechanism is assembled, to scale: links through their joints, each body in
// its own colour with its name, beams, joints, supports, guides, walls, discs and springs
// (io/scene/pose_file.hpp defines the shapes).

std::vector<Shape> shapes_in(const std::filesystem::path& file) {
  const ReadTable table(file, {"shape", "name"}, {"x", "y", "a", "b"});
  std::vector<Shape> list;
  for (std::size_t i = 0; i < table.rows(); ++i)
    list.push_back({table.text("shape")[i], table.text("name")[i], table.column("x")[i], table.column("y")[i],
                    table.column("a")[i], table.column("b")[i]});
  return list;
}

std::vector<Shape> magnified(std::vector<Shape> shapes, double factor) {
  for (auto& s : shapes) {
    if (s.kind != "beam") continue;
    const auto p = DrawnBeamPoint{{s.x, s.y}, {s.a, s.b}}.magnified(factor);
    s.x = p.x(), s.y = p.y();
  }
  Vec2 bearing{0, 0};
  for (std::size_t i = 0, end = 0; i < shapes.size(); i = end) {
    end = i + 1;
    if (shapes[i].kind == "loose") bearing = {shapes[i].x, shapes[i].y};
    if (!is_surface(shapes[i].kind)) continue;
    // The rows of a joint follow each other: its place, the bearing, the journal.
    while (end < shapes.size() && shapes[end].kind == shapes[i].kind && shapes[end].name == shapes[i].name)
      ++end;
    SurfaceLine line;
    for (auto k = i; k < end; ++k)
      line.points.emplace_back(shapes[k].x, shapes[k].y), line.nominal.emplace_back(shapes[k].a, shapes[k].b);
    const auto points = line.magnified(factor, bearing);
    for (auto k = i; k < end; ++k) shapes[k].x = points[k - i].x(), shapes[k].y = points[k - i].y();
  }
  return shapes;
}

void Frame::hold(double x, double y, double r) {
  left = std::min(left, x - r), right = std::max(right, x + r);
  low = std::min(low, y - r), high = std::max(high, y + r);
}

Frame frame_of(const std::vector<Shape>& shapes) {
  Frame f;
  for (const auto& s : shapes) {
    f.hold(s.x, s.y, s.kind == "disc" || s.kind == "loose" ? s.a : 0);
    if (s.kind == "spring" || s.kind == "line") f.hold(s.a, s.b, 0);
  }
  if (!(f.right > f.left || f.high > f.low)) f.hold(f.left, f.low, 1);  // one body at a point
  f.hold(0.5 * (f.left + f.right), 0.5 * (f.low + f.high), 0.2 * f.size());
  return f;
}

namespace {

constexpr std::size_t most_names = 40;  // number of bodies with names in the figure
constexpr Word body_colours[] = {"C1", "C2", "C4", "C5", "C6", "C7", "C8"};

/// Hatching behind a line through (x, y) along (cx, cy): marks a fixed part.
void hatch(Block& block, double x, double y, double cx, double cy, double length, double stroke) {
  const int strokes = std::clamp(static_cast<int>(2 * length / stroke), 8, 60);
  for (int i = 0; i <= strokes; ++i) {
    const double s = length * (static_cast<double>(i) / strokes - 0.5);
    const double px = x + s * cx, py = y + s * cy;
    block.row({px, py}).row({px + stroke * (cy - cx) * 0.7, py - stroke * (cx + cy) * 0.7}).gap();
  }
}

Block supports(const std::vector<Shape>& shapes, double u) {
  Block block("supports");
  for (const auto& s : shapes) {
    if (s.kind != "support") continue;
    block.row({s.x, s.y})
        .row({s.x - 0.7 * u, s.y - 1.2 * u})
        .row({s.x + 0.7 * u, s.y - 1.2 * u})
        .row({s.x, s.y})
        .gap();
    hatch(block, s.x, s.y - 1.2 * u, 1, 0, 2 * u, 0.5 * u);
  }
  return block;
}

Block guides(const std::vector<Shape>& shapes, double u, double width) {
  Block block("guides");
  for (const auto& s : shapes) {
    if (s.kind == "wall") {
      const double half = 0.5 * width;
      block.row({s.x - half * s.a, s.y - half * s.b}).row({s.x + half * s.a, s.y + half * s.b}).gap();
      hatch(block, s.x, s.y, s.a, s.b, width, 0.6 * u);
    }
    if (s.kind == "slider")
      for (const double side : {-0.9 * u, 0.9 * u})
        block.row({s.x - 4 * u * s.a - side * s.b, s.y - 4 * u * s.b + side * s.a})
            .row({s.x + 4 * u * s.a - side * s.b, s.y + 4 * u * s.b + side * s.a})
            .gap();
  }
  return block;
}

Block sliders(const std::vector<Shape>& shapes, double u) {
  Block block("sliders");
  for (const auto& s : shapes) {
    if (s.kind != "slider") continue;
    const auto corner = [&](double along, double across) {
      block.row({s.x + u * (along * s.a - across * s.b), s.y + u * (along * s.b + across * s.a)});
    };
    corner(-1.5, -0.8), corner(1.5, -0.8), corner(1.5, 0.8), corner(-1.5, 0.8), corner(-1.5, -0.8);
    block.gap();
  }
  return block;
}

Block circles(const std::vector<Shape>& shapes, std::string_view kind, double least) {
  Block block(kind);
  for (const auto& s : shapes) {
    if (s.kind != kind || (kind == "loose" && s.a == 0)) continue;  // its surfaces are drawn
    const double r = std::max(s.a, least);
    for (int i = 0; i <= 72; ++i) {
      const double angle = std::acos(-1.0) * i / 36;
      block.row({s.x + r * std::cos(angle), s.y + r * std::sin(angle)});
    }
    block.gap();
  }
  return block;
}

Block springs(const std::vector<Shape>& shapes, double u) {
  Block block("springs");
  for (const auto& s : shapes) {
    if (s.kind != "spring") continue;
    const double dx = s.a - s.x, dy = s.b - s.y, length = std::hypot(dx, dy);
    if (!(length > 0)) continue;
    constexpr int turns = 16;
    for (int i = 0; i <= turns; ++i) {
      const bool end = i < 2 || i > turns - 2;
      const double along = static_cast<double>(i) / turns,
                   across = end ? 0 : (i % 2 ? 0.6 : -0.6) * u / length;
      block.row({s.x + along * dx - across * dy, s.y + along * dy + across * dx});
    }
    block.gap();
  }
  return block;
}

/// Lines through the points of each shape of a kind.
Block outlines(const std::vector<Shape>& shapes, std::string_view kind) {
  Block block(kind);
  const Shape* last = nullptr;
  for (const auto& s : shapes) {
    if (s.kind != kind) continue;
    if (last && last->name != s.name) block.gap();
    block.row({s.x, s.y});
    last = &s;
  }
  return block;
}
/// Lines of the faces of racks and followers.
Block faces(const std::vector<Shape>& shapes) {
  Block block("faces");
  for (const auto& s : shapes)
    if (s.kind == "line") block.row({s.x, s.y}).row({s.a, s.b}).gap();
  return block;
}

Block marks(const std::vector<Shape>& shapes, std::string_view kind) {
  Block block(kind);
  for (const auto& s : shapes)
    if (s.kind == kind) block.row({s.x, s.y});
  return block;
}

/// Shapes with a name in the figure: bodies, and beams by the middle of their lines.
std::vector<Shape> named_in(const std::vector<Shape>& shapes) {
  std::vector<Shape> list;
  for (std::size_t i = 0, end = 0; i < shapes.size(); i = end) {
    const auto& s = shapes[i];
    for (end = i + 1; end < shapes.size() && shapes[end].kind == s.kind && shapes[end].name == s.name;) ++end;
    if (s.kind == "mass" || s.kind == "beam") list.push_back(shapes[(i + end) / 2]);
  }
  return list;
}

/// The number of each body and beam, for its colour.
std::map<std::string, std::size_t> numbers_of(const std::vector<Shape>& shapes) {
  std::map<std::string, std::size_t> numbers;
  for (const auto& s : named_in(shapes)) numbers.emplace(s.name, numbers.size());
  return numbers;
}

void add_links(const std::vector<Shape>& shapes, std::vector<ShapeCurve>& curves) {
  auto colour = numbers_of(shapes);
  std::vector<std::pair<std::string, Block>> bodies;
  const Shape* last = nullptr;
  for (const auto& s : shapes) {
    if (s.kind != "link" && s.kind != "beam") continue;
    if (!last || last->kind != s.kind || last->name != s.name) bodies.emplace_back(s.name, Block(s.name));
    bodies.back().second.row({s.x, s.y});
    last = &s;
  }
  for (auto& [name, block] : bodies)
    curves.push_back({std::move(block), Script().add("with lines lw 3 lc rgb {}",
                                                     body_colours[colour[name] % std::size(body_colours)])});
}

/// Where a name is relative to its body.
struct NamePlace {
  bool left;
  double up;  ///< heights of a letter
};

/// Places of names: each is above or below its body, to the right or the left, such that it is off
/// the links, its own first of all, off other names and within the frame.
class NamePlaces {
 public:
  /// `unit`: length of a cm at the usual text size, in m of the mechanism.
  NamePlaces(const std::vector<Shape>& shapes, const Frame& frame, double unit)
      : frame_(frame), letter_(0.88 * letter_width * unit), line_(line_height * unit) {
    const Shape* last = nullptr;
    for (const auto& s : shapes) {
      const bool line = s.kind == "link" || s.kind == "beam";
      if (line && last && last->kind == s.kind && last->name == s.name) links_.push_back({last, &s});
      last = line ? &s : nullptr;
    }
  }
  NamePlace of(const Shape& mass, double up) {
    NamePlace best{false, up};
    Box taken{};
    double least = INFINITY;
    for (const NamePlace place : {NamePlace{false, up}, {true, up}, {false, -up}, {true, -up}}) {
      const double near = 0.9 * letter_, far = near + letter_ * static_cast<double>(letters(mass.name)),
                   middle = mass.y + place.up * line_;
      const Box box{place.left ? mass.x - far : mass.x + near, place.left ? mass.x - near : mass.x + far,
                    middle - 0.45 * line_, middle + 0.45 * line_};
      if (const double faults = faults_of(box, mass.name); faults < least)
        least = faults, best = place, taken = box;
    }
    names_.push_back(taken);
    return best;
  }

 private:
  struct Box {
    double left, right, low, high;
  };
  double faults_of(const Box& box, const std::string& name) const {
    double faults = 0;
    if (box.right > frame_.right + line_ || box.left < frame_.left - line_) faults += 10;
    for (const auto& other : names_)
      if (box.left < other.right && other.left < box.right && box.low < other.high && other.low < box.high)
        faults += 5;
    for (const auto& [from, to] : links_) {
      bool crosses = false;
      for (int i = 0; i <= 200 && !crosses; ++i) {
        const double x = from->x + (to->x - from->x) * i / 200, y = from->y + (to->y - from->y) * i / 200;
        crosses = x > box.left && x < box.right && y > box.low && y < box.high;
      }
      if (crosses) faults += from->name == name ? 3 : 1;
    }
    return faults;
  }

  Frame frame_;
  double letter_, line_;
  std::vector<std::pair<const Shape*, const Shape*>> links_;
  std::vector<Box> names_;
};

}  // namespace

std::vector<ShapeCurve> pose_curves(const std::vector<Shape>& shapes, double u, double wall) {
  std::vector<ShapeCurve> curves;
  const auto add = [&](Block block, Word style) {
    curves.push_back({std::move(block), Script().add("{}", style)});
  };
  add(guides(shapes, u, wall), "with lines lw 1.2 lc rgb '#888888'");
  add(supports(shapes, u), "with lines lw 1 lc rgb '#444444'");
  add(circles(shapes, "disc", 0.1 * u), "with lines lw 1.6 lc rgb '#444444'");
  add(faces(shapes), "with lines lw 2 lc rgb '#444444'");
  add(outlines(shapes, "outline"), "with lines lw 2 lc rgb '#444444'");
  add(springs(shapes, u), "with lines lw 1.2 lc rgb C4");
  add(sliders(shapes, u), "with lines lw 2 lc rgb '#000000'");
  add_links(shapes, curves);
  add(circles(shapes, "loose", 0.5 * u), "with lines lw 1.4 lc rgb C8");
  add(outlines(shapes, "bearing"), "with lines lw 1.4 lc rgb C8");
  add(outlines(shapes, "journal"), "with lines lw 1.4 lc rgb '#000000'");
  add(marks(shapes, "loose"), "with points pt 7 ps 0.5 lc rgb C8");
  add(marks(shapes, "weld"), "with points pt 5 ps 0.9 lc rgb '#000000'");
  add(marks(shapes, "joint"), "with points pt 9 ps 0.9 lc rgb '#000000'");
  add(marks(shapes, "pin"), "with points pt 7 ps 0.9 lc rgb '#ffffff'");
  add(marks(shapes, "pin"), "with points pt 6 ps 0.9 lw 1.5 lc rgb '#000000'");
  add(marks(shapes, "mass"), "with points pt 1 ps 1.2 lw 1.2 lc rgb '#000000'");
  std::erase_if(curves, [](const ShapeCurve& curve) { return curve.block.empty(); });
  return curves;
}

namespace {

std::vector<std::filesystem::path> draw_pose(const std::filesystem::path& folder) {
  const JsonFile facts(folder / "pose.json");
  const double magnify = facts.find("magnify") ? facts.number("magnify") : 1;
  const auto shapes = magnified(shapes_in(folder / "pose.csv"), magnify);
  if (shapes.empty()) return {};
  const auto frame = frame_of(shapes);
  const double size = frame.size(), u = 0.025 * size;
  Figure f{.name = "pose", .width_cm = 16, .source = "pose.json"};
  const double wide = frame.right - frame.left + 6 * u, tall = frame.high - frame.low + 6 * u;
  const auto style = style_of(folder);
  // scale of parts that follow the texts
  const double unit = style.font_size / Style::usual_font_size;
  f.sized = true;
  f.width_cm = width_of(f, style);
  f.height_cm = style.height ? 0.1 * *style.height
                             : std::clamp(2.6 * unit + (f.width_cm - 2.5 * unit) * tall / wide, 6.0, 18.0);
  f.script.add(
      "set size ratio -1\nset clip two\nset xrange [{}:{}]\nset yrange [{}:{}]\nset xlabel 'x (m)'\nset "
      "ylabel 'y (m)'\n"
      "unset key\nset xtics {}\nset ytics {}\n",
      frame.left - 3 * u, frame.right + 3 * u, frame.low - 3 * u, frame.high + 3 * u,
      with_tics({frame.left - 3 * u, frame.right + 3 * u}, 8, (f.width_cm / unit - 2.5) / letter_width).step,
      with_tics({frame.low - 3 * u, frame.high + 3 * u},
                std::min(8.0, (f.height_cm / unit - 2) / (1.45 * line_height)))
          .step);
  f.caption = facts.text("title");
  if (magnify != 1)
    f.script.add(
        "set label {} at graph 0.02, 0.95 font SMALL noenhanced front\n",
        magnified_words(magnify, std::ranges::any_of(shapes, [](const Shape& s) { return s.kind == "beam"; }),
                        std::ranges::any_of(shapes, [](const Shape& s) { return is_surface(s.kind); })));
  Script plot;
  for (auto& [block, style] : pose_curves(shapes, u, 0.8 * size)) {
    plot.add("{}DATA index {} using 1:2 {} notitle", plot.empty() ? Word("plot ") : Word(", "),
             f.blocks.size(), style);
    f.blocks.push_back(std::move(block));
  }
  auto colour = numbers_of(shapes);
  const double per_cm =
      std::max(wide / (f.width_cm - 2.5 * unit), tall / std::max(f.height_cm - 2 * unit, 1.0));
  NamePlaces places(shapes, frame, per_cm * unit);
  std::size_t count = 0;
  for (const auto& s : named_in(shapes)) {
    if (++count > most_names) continue;
    // A name is higher above a slider or a bearing.
    const bool wide_part = std::ranges::any_of(shapes, [&](const Shape& part) {
      return (part.kind == "slider" || part.kind == "loose") &&
             std::hypot(part.x - s.x, part.y - s.y) < 2 * u;
    });
    const auto place = places.of(s, wide_part ? 2.1 : 0.9);
    f.script.add("set label {} at {},{} {} offset {},{} font SMALL tc rgb {} noenhanced front\n", s.name, s.x,
                 s.y, place.left ? Word("right") : Word("left"), place.left ? -0.9 : 0.9, place.up,
                 body_colours[colour[s.name] % std::size(body_colours)]);
  }
  f.script.add("{}\n", plot);
  return {draw(f, folder)};
}

}  // namespace

const Drawing pose{{"pose.json"}, draw_pose};

}  // namespace freeplay::plots
