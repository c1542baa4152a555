// Coulomb friction of an ideal joint, set-valued in the nonsmooth formulation: −f ∈ B Sgn(u) with
// the sliding speed u along one row (rows/sliding.hpp, rows/spin.hpp). The keys choose the bound B:
//
//     force                  a fixed force: the preload of a translational joint
//     friction, pin_radius   couple of at most μ r |F|; r pin radius, F joint reaction
//     friction               μ S of a translational joint's reaction, with S of evaluation.hpp
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "mechanism/elements/revolute_joint.hpp"
#include "mechanism/elements/translational_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Friction bounded by the joint's own reaction.
struct ReactionFriction {
  double friction = 0;                         ///< μ of sliding, ≥ 0
  double pin_radius = 0;                       ///< m, > 0, of a revolute joint
  std::optional<double> slider_length = {};    ///< m, of a translational joint
  std::optional<double> static_friction = {};  ///< μ_s at rest, ≥ μ
  std::optional<double> stribeck_speed = {};   ///< m/s
};

/// Friction torque or force of an ideal joint.
struct JointFriction {
  static constexpr std::string_view type = "joint-friction";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;                  ///< of the element in the scene
  int joint = -1;                    ///< index into Mechanism::joints
  std::optional<double> force = {};  ///< N, fixed bound, ≥ 0
  /// m/s, speed below which the penalty formulation's force is linear in speed
  std::optional<double> regularisation = {};
  /// friction in proportion to the joint's reaction; empty: a fixed force
  std::optional<ReactionFriction> reaction = {};

  std::string_view what() const {
    return reaction ? "a joint friction" : "a joint friction of fixed force (without friction)";
  }

  static void keys(auto& k, auto& l) {
    const auto* on = k.template joint_of<TranslationalJoint, RevoluteJoint>(
        {"joint", "", "the translational or, with friction, revolute joint"}, l.joint);
    const bool pin = on && std::holds_alternative<RevoluteJoint>(*on);
    k.take({"force", "N", "the bound of the friction force where it is fixed; instead of friction"}, l.force,
           non_negative);
    k.take({"regularisation", "m/s",
            "sliding speed below which friction is linear; required by the penalty formulation"},
           l.regularisation, positive);
    if (auto* f = k.group("friction", l.reaction)) {
      k.need(
          {"friction", "", "μ of sliding: the bound is μ times the joint's own reaction; instead of force"},
          f->friction, non_negative);
      if (k.when(!on || pin, {"pin_radius"}, "belongs to revolute joints"))
        k.need({"pin_radius", "m",
                "radius r of a revolute joint's pin: the couple is at most μ r F, F its reaction"},
               f->pin_radius, positive);
      if (k.when(!pin, {"slider_length"}, "belongs to translational joints"))
        k.take({"slider_length", "m",
                "guide length over which a translational joint's couple acts as contact forces; if absent: "
                "the couple has no friction"},
               f->slider_length, positive);
      k.take({"static_friction", "", "μ_s at rest, at least friction; required with stribeck_speed"},
             f->static_friction, non_negative);
      k.take({"stribeck_speed", "m/s", "v in μ + (μ_s − μ) exp(−(u/v)²), u the sliding speed"},
             f->stribeck_speed, positive);
      k.check(f->static_friction.has_value() == f->stribeck_speed.has_value(),
              f->static_friction ? "static_friction" : "stribeck_speed",
              "static_friction and stribeck_speed go together; one of them is missing");
      k.check(!f->static_friction || *f->static_friction >= f->friction, "static_friction",
              "must be at least friction, ", f->friction);
    }
    k.check(!on || !std::visit([](const auto& j) { return is_loose(j); }, *on), "joint",
            "must be a joint without clearance; one with clearance has friction by its surface");
    k.check(!pin || l.reaction, "joint",
            "must be a translational joint, or the bound be friction times its reaction, not a fixed force");
    k.check(l.force || l.reaction, "force",
            "is missing: the bound is a fixed force, or friction times the joint's reaction");
    k.check(!l.force || !l.reaction, "force",
            "the bound is either a fixed force or friction times the joint's reaction");
  }

 private:
  static bool is_loose(const auto& j) {
    if constexpr (requires { j.clearance; })
      return j.clearance.has_value();
    else
      return false;
  }
};

}  // namespace freeplay
