// A fixed ratio r between two joints with elasticity and damping, such as an elastic belt. With the
// coordinates θ and y of ratio_joint.hpp and x = y − r θ − offset,
//
//     F = −stiffness x − damping ẋ  along y,     −r F  along θ,     U = ½ stiffness x²
#pragma once

#include <string>

#include "mechanism/elements/ratio_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// An elastic ratio between two joints.
struct ElasticRatio : JointRatio {
  static constexpr std::string_view type = "elastic-ratio", what = "an elastic ratio";
  static constexpr auto reports = ForceElement::Kind::torque;
  std::string name = {};  ///< of the element in the scene
  double stiffness = 0;   ///< N m/rad or N/m, ≥ 0
  double damping = 0;     ///< N m s/rad or N s/m, ≥ 0

  static void keys(auto& k, auto& l) {
    const auto* on = JointRatio::keys(k, l);
    k.need({"stiffness", unit(on, "N m/rad", "N/m", "N m/rad"), "rate at the joint that follows, ≥ 0"},
           l.stiffness, non_negative);
    k.take({"damping", unit(on, "N m s/rad", "N s/m", "N m s/rad"), "damping at the joint that follows, ≥ 0"},
           l.damping, non_negative);
  }

  /// Whether it is reported as a torque or as a force.
  ForceElement::Kind kind(const auto& mechanism) const {
    return slider(mechanism) ? ForceElement::Kind::force : reports;
  }
};

}  // namespace freeplay
