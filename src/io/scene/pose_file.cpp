#include "io/scene/pose_file.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <type_traits>

#include "dynamics/assembly/joint_places.hpp"
#include "io/files/output_file.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/beam_line.hpp"
#include "io/scene/bearing_line.hpp"
#include "mechanism/scene.hpp"
#include "values/table.hpp"

namespace freeplay {
namespace {

class PoseShapes {
 public:
  PoseShapes(const Mechanism& m, const std::vector<double>& q) : m_(m), q_(q), corners_(m.bodies.size()) {}

  std::vector<PoseShape> make() {
    for (const auto& joint : m_.joints) std::visit([&](const auto& j) { ends(j, true); }, joint);
    for (const auto& contact : m_.contacts) std::visit([&](const auto& c) { ends(c, false); }, contact);
    for (const auto& load : m_.loads)
      std::visit(
          [&](const auto& l) {
            ends(l, false);
            if constexpr (requires { l.body, l.at.x(); }) corner(l.body, l.at);
          },
          load);
    for (std::size_t b = 0; b < corners_.size(); ++b)
      for (const auto& point : m_.bodies[b].points)
        if (point.name != "mass_centre") corner(static_cast<int>(b), point.at);
    for (std::size_t b = 0; b < corners_.size(); ++b) link(static_cast<int>(b));
    for (const auto& joint : m_.joints) std::visit([&](const auto& j) { draw_joint(j); }, joint);
    for (const auto& contact : m_.contacts) std::visit([&](const auto& c) { draw_contact(c); }, contact);
    for (const auto& group : m_.groups) draw_group(group);
    for (const auto& load : m_.loads) std::visit([&](const auto& l) { draw_load(l); }, load);
    for (const auto& line : beam_lines(m_)) draw_beam(line);
    return std::move(out_);
  }

 private:
  /// Adds a shape at p, which moves with `body`; `more` moves with `other`.
  void row(const char* shape, const std::string& name, int body, const Vec2& p, const Vec2& more = {0, 0},
           int other = ground) {
    out_.push_back({shape, name, body, p, other, more});
  }
  void corner(int body, const Vec2& at) {
    if (body == ground) return;
    auto& list = corners_[static_cast<std::size_t>(body)];
    const auto near = [&](const Vec2& other) { return (other - at).norm() < 1e-12 + 1e-9 * at.norm(); };
    if (std::ranges::none_of(list, near)) list.push_back(at);
  }
  /// The points of an element are corners of its bodies. Exceptions: the point of a slider on the
  /// body it slides on, other than a lever, and the centre of a disc. A bushing has an axis but does not slide.
  template <class X>
  void ends(const X& x, bool joint) {
    if constexpr (requires { x.between[0], x.at[0].x(); }) {
      if constexpr (requires { x.radii; } || std::is_same_v<X, RatioJoint> ||
                    std::is_same_v<X, OutlineContact>)
        return;
      const bool slides = requires { x.axis; }
      &&!std::is_same_v<X, Bushing>;
      if (!slides || (std::is_same_v<X, TranslationalJoint> && x.between[1] != ground))
        corner(x.between[0], x.at[0]);
      if (joint || !slides) corner(x.between[1], x.at[1]);
    }
  }
  /// Draws a body as a polygon through its corners (named points and points of elements), ordered around
  /// their mean. A body with one corner extends to its centre of mass.
  void link(int body) {
    auto list = corners_[static_cast<std::size_t>(body)];
    const auto& name = m_.bodies[static_cast<std::size_t>(body)].name;
    if (list.size() == 1 && list[0].norm() > 0) list.push_back({0, 0});
    if (list.size() > 2) {
      Vec2 middle{0, 0};
      for (const auto& p : list) middle += p / static_cast<double>(list.size());
      std::ranges::sort(list, {},
                        [&](const Vec2& p) { return std::atan2(p.y() - middle.y(), p.x() - middle.x()); });
      const auto first = list.front();
      list.push_back(first);
    }
    if (list.size() > 1)
      for (const auto& p : list) row("link", name, body, place_of(q_, body, p));
    if (!m_.bodies[static_cast<std::size_t>(body)].made)  // otherwise its disc shows it
      row("mass", name, body, place_of(q_, body, {0, 0}));
  }
  void draw_joint(const GearJoint& j) {
    for (const int end : {0, 1})
      row("disc", j.name, j.between[end], place_of(q_, j.between[end], j.at[end]), {j.pitch(end), 0});
  }
  void draw_joint(const RackJoint& j) {
    row("disc", j.name, j.between[0], place_of(q_, j.between[0], j.at[0]), {j.pitch_radius, 0});
    line(j.name, j.between[1], place_of(q_, j.between[1], j.at[1]), direction(j.between[1], j.axis),
         2 * j.pitch_radius);
  }
  /// Draws a slot as a line through its pin, as long as the expected travel of the pin. A guide is
  /// drawn as a box; both may be at the same position.
  void draw_joint(const SlotJoint& j) {
    const auto pin = place_of(q_, j.between[1], j.at[1]), along = direction(j.between[0], j.axis);
    const auto middle = place_of(q_, j.between[0], j.at[0]);
    const double reach = std::max(j.at[1].norm(), (pin - middle).norm());
    line(j.name, j.between[0], middle, along, 1.25 * reach);
    row(j.clearance ? "disc" : "pin", j.name, j.between[1], pin,
        {j.clearance ? j.clearance->pin_radius : 0, 0});
  }
  void draw_joint(const RodJoint& j) {
    row("line", j.name, j.between[0], place_of(q_, j.between[0], j.at[0]),
        place_of(q_, j.between[1], j.at[1]), j.between[1]);
  }
  void draw_joint(const RatioJoint&) {}  // has no place
  void draw_surface(const RevoluteJoint& j, int end, const SurfaceLine& line) {
    const int body = j.between[end];
    for (std::size_t k = 0; k < line.points.size(); ++k)
      row(end == 0 ? "bearing" : "journal", j.name, body, place_of(q_, body, line.points[k]),
          place_of(q_, body, line.nominal[k]), body);
  }
  /// Draws the discs of a group, and its walls as lines.
  void draw_group(const Group& group) {
    for (int n = 0; n < group.size(); ++n)
      row("disc", group.name, group.first + n, place_of(q_, group.first + n, {0, 0}), {group.radius, 0});
    for (int w = 0; w < group.wall_count(); ++w) {
      const auto from = group.walls[static_cast<std::size_t>(w)],
                 to = group.walls[static_cast<std::size_t>(w) + 1];
      line(group.name, ground, 0.5 * (from + to), (to - from).direction(), 0.5 * (to - from).norm());
    }
  }
  /// Draws the outline of a cam, and the face or the roller of its follower.
  void draw_contact(const CamContact& c) {
    const auto profile = c.profile();
    const auto roller = c.follower == CamContact::Follower::roller ? c.roller_radius : 0;
    for (int i = 0; i <= 180; ++i) {
      const double phi = 2 * std::numbers::pi * i / 180;
      const auto lift = profile.at(phi);
      const double h = c.base_radius + roller + lift.h, slope = lift.d1;
      const Vec2 n{std::cos(phi), std::sin(phi)}, t = perp(n);
      // h is the distance of the tangent for a flat face, and of the roller's centre for a roller.
      const Vec2 across = (h * n - slope * t) / std::hypot(h, slope);
      row("outline", c.name, c.between[0],
          place_of(q_, c.between[0], c.at[0] + (roller > 0 ? h * n - roller * across : h * n + slope * t)));
    }
    const auto p = place_of(q_, c.between[1], c.at[1]);
    if (roller > 0)
      row("disc", c.name, c.between[1], p, {roller, 0});
    else
      line(c.name, c.between[1], p, direction(c.between[1], c.axis), c.base_radius);
  }
  /// Draws an outline with its rounded corners, and the disc.
  void draw_contact(const OutlineContact& c) {
    const auto centres = c.centres();
    const auto point = [&](const Vec2& at) {
      row("outline", c.name, c.between[0], place_of(q_, c.between[0], c.at[0] + at));
    };
    const std::size_t n = centres.size();
    for (std::size_t k = 0; k <= n; ++k) {  // the last corner is the first one, which closes the line
      const Vec2 before = c.along(k + n - 1), after = c.along(k);
      const double turn = n == 2 ? std::numbers::pi : std::atan2(cross(before, after), dot(before, after));
      const int pieces = c.corner_radius > 0 ? static_cast<int>(std::ceil(turn / 0.2)) : 0;
      for (int i = 0; i <= pieces; ++i) {
        const double angle = pieces > 0 ? turn * i / pieces : 0;
        const Vec2 along = std::cos(angle) * before + std::sin(angle) * perp(before);
        point(centres[k % n] - c.corner_radius * perp(along));
      }
    }
    row("disc", c.name, c.between[1], place_of(q_, c.between[1], c.at[1]), {c.radius, 0});
    const Vec2 from = middle_of(c.between[0]) - c.at[0];
    bool around = n > 2;
    for (std::size_t k = 0; k < n; ++k) around = around && cross(c.along(k), from - c.corner(k)) > 0;
    const auto away = [&](const Vec2& p) { return (p - from).norm(); };
    if (!around) reach(c.name, c.between[0], c.at[0] + *std::ranges::min_element(c.points, {}, away));
    reach(c.name, c.between[1], c.at[1]);
  }
  /// The place of a body from which its further parts are drawn: its only corner, else its centre of mass.
  Vec2 middle_of(int body) const {
    if (body == ground) return {0, 0};
    const auto& list = corners_[static_cast<std::size_t>(body)];
    return list.size() == 1 ? list[0] : Vec2{0, 0};
  }
  /// A line from a body to a part of it elsewhere, as from a lever to its block.
  void reach(const std::string& name, int body, const Vec2& part) {
    const auto from = middle_of(body);
    if (body != ground && (part - from).norm() > 0)
      row("line", name, body, place_of(q_, body, from), place_of(q_, body, part), body);
  }
  void line(const std::string& name, int body, const Vec2& middle, const Vec2& along, double half) {
    row("line", name, body, middle - half * along, middle + half * along, body);
  }
  template <class J>
  void draw_joint(const J& j) {
    const Joint joint = j;
    const auto p = joint_place(joint, q_);
    // The body to which joint_place refers.
    const int holder = j.between[1] == ground ? j.between[0] : j.between[1];
    if constexpr (requires { j.axis.x(); }) {
      row("slider", j.name, holder, p, direction(j.between[0], j.axis), j.between[0]);
      // A lever reaches to the block that slides on it.
      if (j.between[0] != ground && j.between[1] != ground)
        row("line", j.name, j.between[0], end_place(joint, 0, q_), p, j.between[1]);
    } else if constexpr (requires { j.clearance->bearing_radius; }) {
      const auto lines = surface_lines(m_, j);
      row(j.clearance ? "loose" : "pin", j.name, j.clearance ? j.between[0] : holder,
          j.clearance ? end_place(joint, 0, q_) : p,
          {j.clearance && lines.empty() ? j.clearance->bearing_radius : 0, 0});
      for (std::size_t end = 0; end < lines.size(); ++end) draw_surface(j, static_cast<int>(end), lines[end]);
    } else {
      row(std::string_view(J::type) == "rigid" ? "weld" : "joint", j.name, holder, p);
    }
    if (!(requires { j.axis.x(); }) && (j.between[0] == ground || j.between[1] == ground))
      row("support", j.name, ground, p);
  }
  void draw_contact(const auto& c) {
    if constexpr (requires {
                    c.axis.x();
                    c.between[0], c.at[0].x();
                  })
      row("wall", c.name, c.between[0], place_of(q_, c.between[0], c.at[0]), direction(c.between[0], c.axis),
          c.between[0]);
    if constexpr (requires {
                    c.radius + 0.0;
                    c.between[0], c.at[0].x();
                  })
      row("disc", c.name, c.between[1], place_of(q_, c.between[1], c.at[1]), {c.radius, 0});
    if constexpr (requires {
                    c.radii[0] + 0.0;
                    c.between[0], c.at[0].x();
                  })
      for (const int end : {0, 1})
        row("disc", c.name, c.between[end], place_of(q_, c.between[end], c.at[end]), {c.radii[end], 0});
  }
  void draw_load(const auto& l) {
    if constexpr (requires { l.between[0], l.at[0].x(); }) {
      if constexpr (!std::is_same_v<std::remove_cvref_t<decltype(l)>, BeamElement>)  // drawn as a line
        row("spring", l.name, l.between[0], place_of(q_, l.between[0], l.at[0]),
            place_of(q_, l.between[1], l.at[1]), l.between[1]);
      for (const int end : {0, 1})
        if (l.between[end] == ground) row("support", l.name, ground, l.at[end]);
    }
  }
  void draw_beam(const BeamLine& line) {
    const auto points = drawn(line, [&](int body, const Vec2& at) { return place_of(q_, body, at); });
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto& [first, second] = line.points[i].bodies;
      row("beam", line.name, first, points[i].at, points[i].unloaded, second);
    }
  }
  Vec2 direction(int body, const Vec2& axis) const {
    return place_of(q_, body, axis) - place_of(q_, body, {0, 0});
  }

  const Mechanism& m_;
  const std::vector<double>& q_;
  std::vector<std::vector<Vec2>> corners_;
  std::vector<PoseShape> out_;
};

}  // namespace

std::vector<PoseShape> pose_shapes(const Scene& scene, const std::vector<double>& q) {
  return PoseShapes(scene.mechanism, q).make();
}

std::string pose_table(const Scene& scene, const State& state) {
  Table table("shape,name,x,y,a,b");
  for (const auto& s : pose_shapes(scene, state.q))
    table.row(s.kind, s.name, s.at.x(), s.at.y(), s.more.x(), s.more.y());
  return table.csv();
}

void write_pose(const Scene& scene, const State& state, const std::filesystem::path& folder, double magnify) {
  write_file(folder / "pose.csv", pose_table(scene, state));
  write_json(folder / "pose.json", {{"title", scene.mechanism.title}, {"magnify", magnify}},
             provenance(scene));
}

}  // namespace freeplay
