// A fixed ratio r between two joints: a belt, a chain, a mimic joint, a worm without loss. With the
// angle θ = θ_second − θ_first of one joint, and y the angle or the position along its axis of the joint
// that follows,
//
//     ideal               y = r θ + offset                              one row (rows/motion.hpp)
//     with backlash b     −b/2 ≤ y − r θ − offset ≤ b/2                 two contacts (dynamics/pairs.hpp)
//
// Angles count full turns. The bodies that carry the joints may move; with backlash they are the ground.
// elastic_ratio.hpp is the same relation with a spring.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>

#include "mechanism/body.hpp"
#include "mechanism/elements/revolute_joint.hpp"
#include "mechanism/elements/translational_joint.hpp"

namespace freeplay {

/// A ratio other than 0.
inline constexpr Range not_zero_ratio{[](double x) { return x != 0; }, "a number other than 0"};

/// The linear relation y = ratio θ + offset between the coordinates of two joints.
struct JointRatio {
  int joint = -1;     ///< index into Mechanism::joints: of the joint that follows
  int of = -1;        ///< of the revolute joint that it follows
  double ratio = 1;   ///< rad/rad or m/rad, not 0
  double offset = 0;  ///< rad or m, y at θ = 0

  /// Returns the joint that follows, if k reads a scene.
  static const auto* keys(auto& k, auto& r) {
    const auto* on = k.template joint_of<RevoluteJoint, TranslationalJoint>(
        {"joint", "", "the revolute or translational joint that follows"}, r.joint);
    const auto* leads = k.template joint_of<RevoluteJoint, TranslationalJoint>(
        {"of", "", "the revolute joint whose angle it follows"}, r.of);
    k.check(
        !leads || std::holds_alternative<RevoluteJoint>(*leads), "of",
        "must be a revolute joint, whose angle enters the row; if a revolute joint follows a translational "
        "one, exchange `joint` and `of` and state 1/ratio");
    k.check(!on || r.joint != r.of, "of", "is the joint itself; name another one");
    k.need({"ratio", unit(on, "", "m/rad", "rad/rad or m/rad"),
            "angle (rad) or displacement along its axis (m) for each radian of the joint `of`; < 0 reverses"},
           r.ratio, not_zero_ratio);
    k.ratio_offset({"offset", unit(on, "rad", "m", "rad or m"),
                    "angle or position where the angle of the joint `of` is 0; default: from the bodies' "
                    "stated positions",
                    "from the bodies"},
                   r.offset, r.joint, r.of, r.ratio);
    return on;
  }
  /// One of three units: of an angle, of a position, of either.
  static std::string_view unit(const auto* on, std::string_view turns, std::string_view slides,
                               std::string_view either) {
    return !on ? either : std::holds_alternative<TranslationalJoint>(*on) ? slides : turns;
  }
  /// The joint that follows, if it is a translational one.
  const TranslationalJoint* slider(const auto& mechanism) const {
    return std::get_if<TranslationalJoint>(&mechanism.joints[static_cast<std::size_t>(joint)]);
  }
};

/// Backlash of a ratio between two joints, whose other bodies are the ground.
struct RatioBacklash {
  double play = 0;                       ///< rad or m, > 0, of the joint that follows
  double radius = 1;                     ///< m, > 0, at which an angle's play is a length; a position: 1
  std::optional<double> stiffness = {};  ///< N/m, > 0, at that radius
  int surface = -1;                      ///< index into Mechanism::surfaces
};

/// A fixed ratio between two joints, ideal or with backlash.
struct RatioJoint : JointRatio {
  static constexpr std::string_view type = "ratio";
  std::string name = {};  ///< of the element in the scene
  /// The moving bodies that it couples, by coupled(): of the joint `of`, of the joint that follows. For
  /// reports and the search for a pose; the reader sets them.
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< no points: their centres of mass
  std::optional<RatioBacklash> clearance = {};     ///< empty: an ideal ratio

  std::string_view what() const { return clearance ? "a ratio" : "a ratio without backlash"; }

  static void keys(auto& k, auto& j) {
    const auto* on = JointRatio::keys(k, j);
    k.coupled(j.joint, j.of, j.between);
    if (auto* c = k.group("backlash", j.clearance)) {
      k.need({"backlash", unit(on, "rad", "m", "rad"),
              "total play of the joint that follows, centred at the ratio; if absent: ideal; with it, both "
              "joints have the ground as one of their bodies"},
             c->play, positive);
      if (k.when(!on || !std::holds_alternative<TranslationalJoint>(*on), {"radius"},
                 "belongs to revolute joints"))
        k.need({"radius", "m", "of the pulley of a revolute joint: measures the play as a length"}, c->radius,
               positive);
      k.take({"mesh_stiffness", "N/m", "at the radius or along the axis; penalty contacts need it"},
             c->stiffness, positive);
      const auto* s = k.surface({"surface", "", "the surface of its contacts"}, c->surface);
      k.check(!s || !s->friction, "surface", "must be without friction: nothing slides in a ratio");
      k.grounded(j.joint, j.of);
    }
  }

  /// The moving bodies of the two joints: of `of` first. The second body of a joint is preferred.
  static std::array<int, 2> coupled(const auto& mechanism, int joint, int of) {
    const auto bodies = [&](int index) {
      return std::visit([](const auto& x) { return x.between; },
                        mechanism.joints[static_cast<std::size_t>(index)]);
    };
    const auto leads = bodies(of), follows = bodies(joint);
    for (const int j : {follows[1], follows[0]})
      for (const int i : {leads[1], leads[0]})
        if (i != ground && j != ground && i != j) return {i, j};
    return {leads[1] == follows[1] ? ground : leads[1], follows[1]};
  }
};

}  // namespace freeplay
