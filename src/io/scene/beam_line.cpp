#include "io/scene/beam_line.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

/// A point of a body on the line, with the line's tangent there.
struct Node {
  int body;
  Vec2 at;
  double angle;   // rad, in the frame of the body
  double length;  // m, from the first end
};

/// About this number of points have a line, and each interval between nodes at least two.
constexpr std::size_t points_of_a_line = 48;

Vec2 unloaded_place(double curvature, double length, double s) {
  const double half = 0.5 * curvature * length, chord = std::sin(half);
  if (std::abs(chord) < 1e-9) return {s / length, 0};
  const double size = std::sin(half * s / length) / chord, angle = half * (s / length - 1);
  return {size * std::cos(angle), size * std::sin(angle)};
}

BeamPoint between(const Node& a, const Node& b, double x) {
  const double l = b.length - a.length, before = l * x / (1 + 2 * x), after = l * (1 - x) / (3 - 2 * x);
  return {{a.body, b.body},
          {a.at + before * Vec2{std::cos(a.angle), std::sin(a.angle)},
           b.at - after * Vec2{std::cos(b.angle), std::sin(b.angle)}},
          x * x * (3 - 2 * x),
          {}};
}

BeamLine line_of(const std::string& name, const std::vector<Node>& nodes, double curvature) {
  BeamLine line{name, {between(nodes[0], nodes[1], 0)}};
  const std::size_t steps = std::max<std::size_t>(2, points_of_a_line / (nodes.size() - 1));
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k)
    for (std::size_t i = 1; i <= steps; ++i) {
      const double x = static_cast<double>(i) / static_cast<double>(steps);
      line.points.push_back(between(nodes[k], nodes[k + 1], x));
      line.points.back().unloaded = unloaded_place(
          curvature, nodes.back().length, nodes[k].length + x * (nodes[k + 1].length - nodes[k].length));
    }
  return line;
}

BeamLine line_of(const Beam& beam) {
  const double l = beam.piece();
  const int last = beam.first + beam.elements - 1;
  // A free end is half a piece beyond the middle of the outer piece, which is rigid there.
  const auto end = [&](std::size_t k) -> Node {
    const bool begins = k == 0;
    const double length = begins ? 0 : beam.length;
    if (beam.is_free(k)) return {begins ? beam.first : last, {begins ? -0.5 * l : 0.5 * l, 0}, 0, length};
    return {beam.between[k], beam.at[k], begins ? beam.angles.x() : beam.angles.y(), length};
  };
  std::vector<Node> nodes{end(0)};
  for (int n = 0; n < beam.elements; ++n) nodes.push_back({beam.first + n, {0, 0}, 0, (n + 0.5) * l});
  nodes.push_back(end(1));
  return line_of(beam.name, nodes, beam.curvature);
}

BeamLine line_of(const BeamElement& x) {
  return line_of(x.name,
                 {{x.between[0], x.at[0], x.angles.x(), 0}, {x.between[1], x.at[1], x.angles.y(), x.length}},
                 x.curvature);
}

}  // namespace

std::vector<BeamLine> beam_lines(const Mechanism& mechanism) {
  std::vector<BeamLine> lines;
  for (const auto& beam : mechanism.beams) lines.push_back(line_of(beam));
  for (const auto& load : mechanism.loads)
    if (const auto* x = std::get_if<BeamElement>(&load); x && !x->made) lines.push_back(line_of(*x));
  return lines;
}

}  // namespace freeplay
