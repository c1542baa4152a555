// Coulomb friction of an ideal joint, set-valued in the nonsmooth formulation: −f ∈ B Sgn(u) with
// the sliding speed u along one row (rows/sliding.hpp, rows/spin.hpp). The keys choose the bound B:
//
//     force                  a fixed force: the preload of a translational joint
//     torque                 a fixed torque of a revolute joint
//     friction, pin_radius   couple of at most μ r |F|; r pin radius, F joint reaction
//     friction               μ S of a translational joint's reaction, with S of evaluation.hpp
//
// Each may fall from a static value at rest (Stribeck), here of a force: F + (F_s − F) exp(−(|u|/v)ⁿ).
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "mechanism/elements/revolute_joint.hpp"
#include "mechanism/elements/translational_joint.hpp"
#include "mechanism/static_friction.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Friction bounded by the joint's own reaction.
struct ReactionFriction {
  double friction = 0;                       ///< μ of sliding, ≥ 0
  double pin_radius = 0;                     ///< m, > 0, of a revolute joint
  std::optional<double> slider_length = {};  ///< m, of a translational joint
  StaticFriction peak = {};                  ///< μ_s, v_S and n
};

/// Static value of a fixed bound.
struct FrictionPeak {
  double bound = 0;                              ///< N or N m, at rest, at least that of sliding
  double stribeck_speed = 0;                     ///< m/s or rad/s, > 0
  std::optional<double> stribeck_exponent = {};  ///< n, 1 to 100; empty: 2

  static void keys(auto& k, const auto& bound, const auto& speed, auto& p) {
    k.need(bound, p.bound, non_negative);
    k.need(speed, p.stribeck_speed, positive);
    StaticFriction::exponent(k, p.stribeck_exponent);
  }
};

/// Friction torque or force of an ideal joint.
struct JointFriction {
  static constexpr std::string_view type = "joint-friction";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;                   ///< of the element in the scene
  int joint = -1;                     ///< index into Mechanism::joints
  std::optional<double> force = {};   ///< N, fixed bound, ≥ 0
  std::optional<double> torque = {};  ///< N m, fixed bound of a revolute joint, ≥ 0
  /// m/s, or rad/s of a torque: speed below which the penalty formulation's force is linear in speed
  std::optional<double> regularisation = {};
  std::optional<FrictionPeak> peak = {};  ///< of a fixed bound
  /// friction in proportion to the joint's reaction; empty: a fixed force or torque
  std::optional<ReactionFriction> reaction = {};

  std::string_view what() const {
    return reaction ? "a joint friction" : "a joint friction of fixed force (without friction)";
  }

  static void keys(auto& k, auto& l) {
    const auto* on = k.template joint_of<TranslationalJoint, RevoluteJoint>(
        {"joint", "", "the translational or, with torque or friction, revolute joint"}, l.joint);
    const bool pin = on && std::holds_alternative<RevoluteJoint>(*on);
    k.take({"force", "N", "the bound of the friction force where it is fixed; instead of friction"}, l.force,
           non_negative);
    const bool turns = k.when(!on || pin, {"torque", "static_torque"}, "belongs to revolute joints");
    if (turns)
      k.take({"torque", "N m", "the bound of a revolute joint's friction torque where it is fixed"}, l.torque,
             non_negative);
    const bool torque = (!on || pin) && l.torque;
    if (k.when(!torque))
      k.take({"regularisation", "m/s",
              "sliding speed below which friction is linear; required by the penalty formulation"},
             l.regularisation, positive);
    if (k.when(torque))
      k.take({"regularisation", "rad/s", "the same of a torque"}, l.regularisation, positive);
    if (k.when(!pin, {"static_force"}, "belongs to translational joints"))
      if (auto* p = k.group("static_force", l.peak)) {
        FrictionPeak::keys(
            k, Key{"static_force", "N", "F_s of a fixed force F at rest, at least force"},
            Key{"stribeck_speed", "m/s", "v in F + (F_s − F) exp(−(|u|/v)ⁿ), u the sliding speed"}, *p);
        k.check(!l.force || p->bound >= *l.force, "static_force", "must be at least force, ",
                l.force.value_or(0));
        k.check(l.force.has_value(), "static_force", "goes with force, which is missing");
      }
    if (turns)
      if (auto* p = k.group("static_torque", l.peak)) {
        FrictionPeak::keys(
            k, Key{"static_torque", "N m", "T_s of a fixed torque T at rest, at least torque"},
            Key{"stribeck_speed", "rad/s", "v in T + (T_s − T) exp(−(|u|/v)ⁿ), u the relative rotation rate"},
            *p);
        k.check(!l.torque || p->bound >= *l.torque, "static_torque", "must be at least torque, ",
                l.torque.value_or(0));
        k.check(l.torque.has_value(), "static_torque", "goes with torque, which is missing");
      }
    if (auto* f = k.group("friction", l.reaction)) {
      k.check(!l.force, "force", "the bound is either a fixed force or friction times the joint's reaction");
      k.check(!torque, "torque", "the bound is either a fixed torque or friction times the joint's reaction");
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
      StaticFriction::keys(k, f->peak, f->friction);
    }
    k.check(!on || !std::visit([](const auto& j) { return is_loose(j); }, *on), "joint",
            "must be a joint without clearance; one with clearance has friction by its surface");
    k.check(
        !pin || torque || l.reaction, "joint",
        "must be a translational joint, or the bound a torque or friction times the joint's reaction, not a "
        "fixed force");
    k.check(l.force || torque || l.reaction, "force",
            "is missing: the bound is a fixed force, or friction times the joint's reaction");
    k.check(!torque || !l.force, "torque", "the bound is either a fixed torque or a fixed force, not both");
    k.when(l.peak || l.reaction, {"stribeck_speed", "stribeck_exponent"},
           "goes with a static value: static_force, static_torque or static_friction");
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
