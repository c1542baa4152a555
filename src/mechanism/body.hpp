// A moving body and the ground.
#pragma once

#include <string>
#include <vector>

#include "mechanism/keys.hpp"
#include "values/vec2.hpp"

namespace freeplay {

/// Index of the ground wherever a body is named by its index.
inline constexpr int ground = -1;

/// A point that joints may name in place of its coordinates.
struct NamedPoint {
  std::string name;
  Vec2 at{0, 0};  ///< m, in the body's frame, from its centre of mass
};

struct Body {
  static constexpr std::string_view what = "a body";
  std::string name;
  double mass = 0;                      ///< kg, > 0
  double inertia = 0;                   ///< kg m², about the centre of mass, > 0; of a point 0
  Vec2 position{0, 0};                  ///< m, centre of mass at the start; may be rough
  double angle = 0;                     ///< rad, at the start; may be rough
  Vec2 velocity{0, 0};                  ///< m/s, of the centre of mass at the start; may be rough
  double angular_velocity = 0;          ///< rad/s, at the start; may be rough
  std::vector<NamedPoint> points = {};  ///< names of places; what uses one holds its coordinates
  bool of_group = false;                ///< made by a group, which says all of it
  bool point = false;                   ///< a mass without rotation: no inertia, no angle (point_bodies.hpp)

  static void keys(auto& k, auto& b) {
    k.check(b.name != "ground", "", "\"ground\" is the fixed frame and cannot be a body");
    k.need({"mass", "kg", "mass, > 0"}, b.mass, positive);
    k.flag({"point", "", "true: a point body, which has no rotation, and no inertia"}, b.point);
    const bool turns = k.when(!b.point, {"inertia", "angle", "angular_velocity", "points"},
                              "belongs to a body that can turn; a point body has a centre and no more");
    if (turns)
      k.need({"inertia", "kg m²", "moment of inertia about the centre of mass, > 0; a point body has none"},
             b.inertia, positive);
    k.take({"position", "m", "centre of mass at the start; may be rough"}, b.position);
    if (turns) k.take({"angle", "rad", "angle at the start; may be rough"}, b.angle);
    k.take({"velocity", "m/s", "velocity of the centre of mass at the start; may be rough"}, b.velocity);
    if (!turns) return;
    k.take({"angular_velocity", "rad/s", "angular velocity at the start; may be rough"}, b.angular_velocity);
    k.points(
        {"points", "m",
         "points by name, { A = [x, y], ... }, that `at` may name; in a frame of your choice with the body's "
         "directions, in which the point mass_centre is the centre of mass (left out: its origin)"},
        "mass_centre", b.points);
  }
};

}  // namespace freeplay
