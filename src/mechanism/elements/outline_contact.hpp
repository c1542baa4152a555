// A disc (or a point) of the second body and a convex outline of the first: one contact
// (dynamics/outline_pair.hpp).
//
// The outline is the polygon through `points`, whose corners may be rounded by arcs of `corner_radius`
// tangent to both edges. Two points define a thin face, touched from both sides and at its ends; with a
// corner radius it is a plate of that half thickness, whose ends are half circles around the points. With
// r = corner_radius, unit vectors u along the edges and their inner normals n = perp u, the centres of the
// arcs are
//
//     c_k = p_k + r (n_{k−1} + n_k)/(1 + n_{k−1}·n_k)       (c_k = p_k for two points)
//
// The stiffness of penalty contacts is that of the disc on a corner, for all places.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "mechanism/body.hpp"

namespace freeplay {

/// Contact of a disc of the second body with a convex outline of the first.
struct OutlineContact {
  static constexpr std::string_view type = "outline";
  /// Sine of the least angle between successive edges.
  static constexpr double least_turn = 1e-9;
  std::string name;                            ///< of the element in the scene
  std::array<int, 2> between{ground, ground};  ///< first and second body: indices, or ground
  /// The point from which `points` count; the disc's centre.
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  /// m, corners in the axes of the first body, counterclockwise
  std::vector<Vec2> points = {};
  double corner_radius = 0;  ///< m, ≥ 0
  double radius = 0;         ///< m, ≥ 0, of the disc
  /// N/m, > 0, of penalty contacts; empty: that of Hertz's contact of the disc on a corner
  std::optional<double> stiffness = {};
  int surface = -1;  ///< index into Mechanism::surfaces

  std::string_view what() const { return "a contact with an outline"; }

  /// Point k, counted around the outline.
  const Vec2& corner(std::size_t k) const { return points[k % points.size()]; }
  /// Unit vector from point k to the next one.
  Vec2 along(std::size_t k) const { return (corner(k + 1) - corner(k)).direction(); }
  /// Centres of the corners' arcs (m).
  std::vector<Vec2> centres() const {
    if (points.size() < 3) return points;
    std::vector<Vec2> list;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vec2 before = perp(along(k + points.size() - 1)), after = perp(along(k));
      list.push_back(corner(k) + corner_radius / (1 + dot(before, after)) * (before + after));
    }
    return list;
  }

  static void keys(auto& k, auto& c) {
    k.between("two bodies, or \"ground\" and a body; the outline is on the first", c.between);
    k.ends("the point from which the points of the outline count, and the centre of the disc", c.at);
    k.way({"points", "m",
           "corners of a convex outline in the first body's axes, counterclockwise, [[x, y], ...]; two "
           "points: a thin face, touched from both sides and at its ends"},
          c.points);
    k.take({"corner_radius", "m",
            "radius of the rounded corners; of a face of two points: half its thickness and the radius of "
            "its ends"},
           c.corner_radius, non_negative);
    k.take({"radius", "m", "radius of the disc; 0: a point"}, c.radius, non_negative);
    k.take({"stiffness", "N/m",
            "of the contact, for penalty contacts, required without a radius of the disc or of the corners; "
            "if absent: Hertz's, from these radii and the surface"},
           c.stiffness, positive);
    k.surface({"surface", "", "the surface of the contact"}, c.surface);
    c.check_outline(k);
  }
  /// Refuses an impossible outline.
  void check_outline(auto& k) const {
    const std::size_t n = points.size();
    k.check(n >= 2, "points", "must be two corners or more, counterclockwise: [[x, y], ...]");
    k.check(radius + corner_radius > 0, "corner_radius",
            "must be greater than 0 without a radius: a point on a sharp corner has no normal");
    if (n < 3) return;
    k.check((corner(0) - corner(n - 1)).norm() > 0, "points",
            "end where they begin; the outline is closed without the first point at its end");
    double turn = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 before = along(i + n - 1), after = along(i);
      k.check(cross(before, after) > least_turn, "points",
              "must be convex and counterclockwise: the outline does not turn left at point ",
              static_cast<double>(i + 1), "; use several contacts for a nonconvex outline");
      turn += std::atan2(cross(before, after), dot(before, after));
    }
    k.check(turn < 7, "points", "must go once around the outline, go around it ", turn / 6.283185307179586,
            " times");
    const auto centre = centres();
    for (std::size_t i = 0; i < n; ++i)
      k.check(dot(centre[(i + 1) % n] - centre[i], along(i)) > 0, "corner_radius",
              "is too great: ", corner_radius, " m leave nothing of the edge after point ",
              static_cast<double>(i + 1));
  }
};

}  // namespace freeplay
