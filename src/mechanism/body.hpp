// Facts of a moving body, and the index of the ground.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mechanism/keys.hpp"
#include "values/vec2.hpp"

namespace freeplay {

/// Index of the ground, wherever a body is given by index.
inline constexpr int ground = -1;

/// A named point, which joints may name in place of coordinates.
struct NamedPoint {
  std::string name;  ///< of the element in the scene
  Vec2 at{0, 0};     ///< m, in the body's frame, from its centre of mass
};

/// A vector (m or m/s) that a scene may state; `{x, y}` states it.
struct StatedVec2 : std::optional<Vec2> {
  using std::optional<Vec2>::optional;
  /// From its components.
  constexpr StatedVec2(double x, double y) : std::optional<Vec2>(Vec2{x, y}) {}
  /// Whether both are absent, or equal.
  friend constexpr bool operator==(const StatedVec2& a, const StatedVec2& b) {
    return a.has_value() == b.has_value() && (!a || *a == *b);
  }
  /// Whether it is stated with this value.
  friend constexpr bool operator==(const StatedVec2& a, const Vec2& b) { return a && *a == b; }
};

/// A moving body: mass, inertia and initial motion.
struct Body {
  static constexpr std::string_view what = "a body";
  std::string name;  ///< of the element in the scene
  double mass = 0;   ///< kg, > 0
  /// kg m², about the centre of mass, > 0; 0 for a point body
  double inertia = 0;
  /// @name Initial values; the start keeps stated ones and determines absent ones (assembly.hpp)
  ///@{
  StatedVec2 position = {};                     ///< m, of the centre of mass
  std::optional<double> angle = {};             ///< rad
  StatedVec2 velocity = {};                     ///< m/s, of the centre of mass
  std::optional<double> angular_velocity = {};  ///< rad/s
  ///@}
  std::vector<NamedPoint> points = {};  ///< the elements that use them store coordinates
  bool made = false;                    ///< made from a group or a beam, which states all its facts
  /// a mass without rotation: no inertia, no angle (point_bodies.hpp)
  bool point = false;

  static void keys(auto& k, auto& b) {
    k.check(b.name != "ground", "", "\"ground\" is the fixed frame and cannot be a body");
    k.need({"mass", "kg", "mass, > 0"}, b.mass, positive);
    k.flag({"point", "", "true: a point body, which has no rotation, and no inertia"}, b.point);
    const bool turns = k.when(!b.point, {"inertia", "angle", "angular_velocity", "points"},
                              "needs a body with rotation; a point body has a centre only");
    if (turns)
      k.need({"inertia", "kg m²", "moment of inertia about the centre of mass, > 0; a point body has none"},
             b.inertia, positive);
    k.take({"position", "m", "initial centre of mass", "the joints determine it"}, b.position);
    if (turns) k.take({"angle", "rad", "initial angle", "the joints determine it"}, b.angle, any_number);
    k.take({"velocity", "m/s", "initial velocity of the centre of mass", "the joints determine it"},
           b.velocity);
    if (!turns) return;
    k.take({"angular_velocity", "rad/s", "initial angular velocity", "the joints determine it"},
           b.angular_velocity, any_number);
    k.points({"points", "m",
              "named points for `at`, { A = [x, y], ... }, in a frame with the body's directions; the point "
              "mass_centre is the centre of mass (if absent: the origin)"},
             "mass_centre", b.points);
  }
};

}  // namespace freeplay
