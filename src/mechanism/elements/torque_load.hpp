// Torque on a body. A curve may scale it: M(x) = torque·factor(x).
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "mechanism/argument.hpp"
#include "mechanism/body.hpp"
#include "mechanism/curve.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// A torque on a body.
struct TorqueLoad {
  static constexpr std::string_view type = "torque", what = "a torque";
  static constexpr auto reports = ForceElement::Kind::torque;
  std::string name;  ///< of the element in the scene
  /// index into Mechanism::bodies
  int body = ground;
  double torque = 0;  ///< N m
  int factor = -1;    ///< index into Mechanism::curves; −1: constant torque
  /// argument of the curve
  Argument against = Argument::time;
  /// the joint whose angle, position or speed is the argument
  OtherJoint other = {};

  static void keys(auto& k, auto& l) {
    k.body({"body", "", "the loaded body"}, l.body);
    k.need({"torque", "N m", "the torque, or its amplitude with `factor`"}, l.torque, any_number);
    k.maybe_curve({"factor", "", "name of a curve that scales it; if absent: constant"}, l.factor);
    if (k.when(l.factor >= 0, {"against"}, "goes with factor"))
      k.choose({"against", "", "argument of the factor: "}, l.against);
    k.check(l.factor < 0 || l.against != Argument::position, "against", "a torque has an angle, no position");
    OtherJoint::keys(k, l.other, l.against, l.factor >= 0);
  }
};

}  // namespace freeplay
