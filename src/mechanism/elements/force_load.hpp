// Force F on a point of a body, in axes of the world or of the body; its power is F·v_P. A curve
// may scale it: F(x) = force·factor(x). A function of the caller may replace it
// (mechanism/outside.hpp).
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "mechanism/argument.hpp"
#include "mechanism/body.hpp"
#include "mechanism/curve.hpp"
#include "mechanism/outside.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// A force on a point of a body.
struct ForceLoad {
  /// Axes along which the components are given.
  enum class Axes { world, body };
  static constexpr std::string_view type = "force", what = "a force";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;  ///< of the element in the scene
  /// index into Mechanism::bodies
  int body = ground;
  Vec2 at{0, 0};     ///< m, in the body's frame
  Vec2 force{0, 0};  ///< N
  /// axes of the components
  Axes axes = Axes::world;
  int factor = -1;  ///< index into Mechanism::curves; −1: constant force
  /// argument of the curves
  Argument against = Argument::time;
  /// the joint whose angle, position or speed is the argument
  OtherJoint other = {};
  std::shared_ptr<const OwnForce> own = {};  ///< replaces force and factor; it has no key

  static void keys(auto& k, auto& l) {
    k.body({"body", "", "the loaded body"}, l.body);
    k.point_of({"at", "m", "the loaded point in the body's frame"}, l.body, l.at);
    k.need({"force", "N", "the force, or its amplitude with `factor`"}, l.force);
    k.choose_other({"axes", "", "directions of the force: "}, l.axes);
    k.maybe_curve({"factor", "", "name of a curve that scales it; if absent: constant"}, l.factor);
    if (k.when(l.factor >= 0, {"against"}, "goes with factor"))
      k.choose({"against", "", "argument of the factor: "}, l.against);
    OtherJoint::keys(k, l.other, l.against, l.factor >= 0);
    k.check(l.factor < 0 || l.axes == Axes::world || l.against != Argument::position, "against",
            "a force in the body's own directions has no direction in the world to take a position along");
    k.check(l.factor < 0 || !l.force.is_zero(), "force", "must not be zero where a factor scales it");
  }
};

inline constexpr auto force_axes =
    complete<ForceLoad::Axes>({{ForceLoad::Axes::world, "world", "fixed directions"},
                               {ForceLoad::Axes::body, "body", "turning with the body"}});
constexpr std::span<const Choice<ForceLoad::Axes>> choices(ForceLoad::Axes) { return force_axes; }

}  // namespace freeplay
