// Torque of a revolute joint, or force along the axis of a translational joint. It acts on the
// second body, and its opposite on the first. Its curve depends on time, on the joint's angle or
// position, on its speed, or on the angle of another joint. The power is M (ω_j − ω_i) or F ṡ.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <type_traits>

#include "mechanism/argument.hpp"
#include "mechanism/curve.hpp"
#include "mechanism/elements/revolute_joint.hpp"
#include "mechanism/elements/translational_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Torque on a revolute joint, given by a constant or a curve.
struct TorqueCurveDrive {
  static constexpr std::string_view what = "a torque curve drive";
  static constexpr std::array<std::string_view, 1> chosen_by{"torque_curve"};
  static constexpr auto reports = ForceElement::Kind::drive;
  std::string name;  ///< of the element in the scene
  int joint = -1;    ///< index into Mechanism::joints
  int curve = -1;    ///< index into Mechanism::curves
  /// argument of the curve
  Argument against = Argument::time;
  /// the joint whose angle, position or speed is the argument, if it is another one
  OtherJoint other = {};

  static void keys(auto& k, auto& d) {
    k.template joint<RevoluteJoint>({"joint", "", "the revolute joint that is driven"}, d.joint);
    k.curve({"torque_curve", "N m", "name of the curve of the torque on the second body"}, d.curve);
    k.choose({"against", "", "argument of the curve: "}, d.against);
    k.check(d.against != Argument::position, "against", "a revolute joint has an angle, no position");
    OtherJoint::keys(k, d.other, d.against, true);
  }
  double greatest_effort(const auto& mechanism) const {
    return mechanism.curves[curve].lay().greatest().value;
  }
};

/// Force along the axis of a translational joint, given by a constant or a curve.
struct ForceDrive {
  static constexpr std::string_view what = "a force drive";
  static constexpr std::array<std::string_view, 1> chosen_by{"force"};
  static constexpr auto reports = ForceElement::Kind::push;
  std::string name;  ///< of the element in the scene
  int joint = -1;    ///< index into Mechanism::joints
  /// N, along the joint's axis
  CurveOr force = {};
  /// argument of the curve
  Argument against = Argument::time;
  /// the joint whose angle, position or speed is the argument, if it is another one
  OtherJoint other = {};

  static void keys(auto& k, auto& d) {
    k.template joint<TranslationalJoint>({"joint", "", "the translational joint that is driven"}, d.joint);
    k.number_or_curve(
        {"force", "N", "along its axis on the second body, its opposite on the first; a number or a curve"},
        d.force);
    if (k.when(d.force.curve >= 0, {"against"}, "goes with a curve"))
      k.choose({"against", "", "argument of the curve: "}, d.against);
    OtherJoint::keys(k, d.other, d.against, d.force.curve >= 0);
    k.check(
        d.force.curve < 0 || d.against != Argument::angle || d.other.of >= 0, "against",
        "a translational joint has a position, no angle; `of` names a revolute joint whose angle is meant");
  }
  double greatest_effort(const auto& mechanism) const { return force.lay(mechanism.curves).greatest().value; }
};

}  // namespace freeplay
