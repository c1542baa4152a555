// Prescribed motion of a joint along a curve, one row (rows/motion.hpp). s is the angle
// θ_second − θ_first of a revolute joint, or the position of a translational one along its axis:
//
//     s = y(t) or y(angle of another joint)        or        ṡ = y(t),  s = initial + ∫₀ᵗ y
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <variant>

#include "mechanism/curve.hpp"
#include "mechanism/elements/revolute_joint.hpp"
#include "mechanism/elements/translational_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Drive of a joint with prescribed position or velocity.
struct MotionDrive {
  static constexpr std::string_view what = "a motion drive";
  static constexpr std::array<std::string_view, 2> chosen_by{"position", "velocity"};
  static constexpr auto reports = ForceElement::Kind::drive;
  std::string name;  ///< of the element in the scene
  int joint = -1;    ///< index into Mechanism::joints
  /// Index into Mechanism::curves of the given one; the other is −1.
  int position = -1, velocity = -1;
  int of = -1;         ///< joint whose angle is the argument of the position; −1: time
  double initial = 0;  ///< rad or m, at t = 0, used with `velocity`
  /// whether its joint's angle is the crank angle even if it is not the first drive
  bool crank = false;

  static void keys(auto& k, auto& d) {
    k.moving_joint({"joint", "", "the revolute or translational joint that is driven"}, d.joint);
    k.maybe_curve(
        {"position", "",
         "curve of the joint's angle (rad) or place along its axis (m) against time (s) or the angle "
         "of another joint"},
        d.position, Curve::Use::place);
    k.maybe_curve({"velocity", "", "curve of its rate (rad/s or m/s) against time (s)"}, d.velocity,
                  Curve::Use::rate);
    if (k.when(d.position >= 0, {"of"}, "goes with position"))
      k.maybe_joint({"of", "", "revolute joint whose angle (rad) the position follows; if absent: time"},
                    d.of);
    k.check(d.position < 0 || d.of < 0 || d.of != d.joint, "of", "is the driven joint itself");
    if (k.when(d.velocity >= 0, {"initial"}, "goes with velocity"))
      k.joint_place(
          {"initial", "rad or m", "angle or place at t = 0; default: that of the bodies", "from the bodies"},
          d.initial, d.joint);
    k.check((d.position < 0) != (d.velocity < 0), "", "needs exactly one of position and velocity");
    k.take({"crank", "", "its joint's angle is the crank angle even if it is not the first drive"}, d.crank);
  }

  /// Whether the joint is translational.
  bool slides(const auto& mechanism) const {
    return std::holds_alternative<TranslationalJoint>(mechanism.joints[joint]);
  }
  /// Whether its effort is a torque or a force.
  ForceElement::Kind kind(const auto& mechanism) const {
    return slides(mechanism) ? ForceElement::Kind::push : ForceElement::Kind::drive;
  }
  /// Greatest prescribed rate (rad/s, m/s); 0 if the position follows an angle.
  double pace(const auto& mechanism) const { return slides(mechanism) ? 0 : greatest_rate(mechanism); }
  double slide_pace(const auto& mechanism) const { return slides(mechanism) ? greatest_rate(mechanism) : 0; }
  double greatest_rate(const auto& mechanism) const {
    return of >= 0 ? 0 : course(mechanism.curves).greatest().slope;
  }
  /// Time scale (s) of the prescribed rate: 1/ω for a sine; infinite if the rate is constant or
  /// follows an angle.
  double change_time(const auto& mechanism) const {
    if (of >= 0) return INFINITY;
    const auto most = course(mechanism.curves).greatest();
    return most.bend > 0 ? most.slope / most.bend : INFINITY;
  }
  /// s as a function of time or of the angle.
  auto course(const auto& curves) const {
    if (position >= 0) return curves[position].lay(Curve::Use::place);
    return curves[velocity].lay(Curve::Use::rate).antiderivative(0, initial);
  }
};

}  // namespace freeplay
