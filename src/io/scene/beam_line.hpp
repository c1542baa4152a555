// The centre line of a beam as points in the order of its length, for figures of its deflection.
//
// Between two neighbouring nodes (ends and middles of pieces) at the places p, q with the unit tangents t, u, a
// length l of the unloaded beam apart, the line is the cubic (Hermite) curve
//
//     r(x) = h(1 − x) (p + l x/(1 + 2x) t) + h(x) (q − l (1 − x)/(3 − 2x) u),    h(x) = x² (3 − 2x),  0 ≤ x ≤ 1:
//
// a weighted mean of two points, each fixed to the body of one node. Magnified M times, r is drawn at c + M (r − c),
// where c is its place on the unloaded beam: the chord between the ends of the line, or for a beam of curvature κ the
// arc through them, 0 ≤ s ≤ L along it, in units of the chord and with the axes along and left of it
//
//     c = exp(iκ (s − L)/2) sin(κs/2)/sin(κL/2).
//
// For a beam that closes to a circle when unloaded, which has no chord, c is on the line between the ends, too.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "values/vec2.hpp"

namespace freeplay {

struct Mechanism;

/// A point of the line.
struct BeamPoint {
  std::array<int, 2> bodies;  ///< those of the two nodes beside it; −1 is the ground
  std::array<Vec2, 2> at;     ///< m, the point fixed to each, in its frame
  double share;               ///< weight of the second point in their mean
  Vec2 unloaded;              ///< c
};

/// The line of a beam, or of a beam element that a scene states by itself.
struct BeamLine {
  std::string name;               ///< of the beam or element
  std::vector<BeamPoint> points;  ///< from its first to its second end
};

/// The lines of all beams of a mechanism.
std::vector<BeamLine> beam_lines(const Mechanism& mechanism);

/// A point of a line in a pose, and its place on the unloaded beam.
struct DrawnBeamPoint {
  Vec2 at, unloaded;  ///< m
  /// Its place with the deflection magnified.
  Vec2 magnified(double factor) const { return unloaded + factor * (at - unloaded); }
};

/// The line in a pose. place(body, point) is the place of a body's point (m).
template <class Place>
std::vector<DrawnBeamPoint> drawn(const BeamLine& line, const Place& place) {
  std::vector<DrawnBeamPoint> list;
  for (const auto& p : line.points)
    list.push_back({(1 - p.share) * place(p.bodies[0], p.at[0]) + p.share * place(p.bodies[1], p.at[1]), {}});
  const Vec2 first = list.front().at, chord = list.back().at - first;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto& c = line.points[i].unloaded;
    list[i].unloaded = first + c.x() * chord + c.y() * perp(chord);
  }
  return list;
}

}  // namespace freeplay
