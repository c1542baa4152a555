// Dynamics of mechanism/elements/joint_friction.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/joint_friction.hpp"

namespace freeplay {

template <>
struct Dynamics<JointFriction> : JointFriction {
  auto link(auto& b) const {
    return std::visit([&](const auto& j) { return b.link(j.between, j.at); }, b.mechanism().joints[joint]);
  }
  /// Its kind in forces.csv: a torque for a pin.
  auto reports_as(auto& b) const {
    return std::holds_alternative<RevoluteJoint>(b.mechanism().joints[joint]) ? ForceElement::Kind::torque
                                                                              : reports;
  }
  void build(auto& b) const {
    const auto& on = b.mechanism().joints[joint];
    const auto* guide = std::get_if<TranslationalJoint>(&on);
    if (!reaction) return b.sliding(link(b), guide->axis, name, *force, regularisation);
    auto bound = b.reaction_bound(joint);
    bound.friction = reaction->friction;
    if (reaction->static_friction) bound.more = *reaction->static_friction - reaction->friction;
    if (reaction->stribeck_speed) bound.stribeck = *reaction->stribeck_speed;
    if (guide && reaction->slider_length) bound.couple = 2 / *reaction->slider_length;
    if (guide)
      b.sliding(link(b), guide->axis, name, bound, regularisation);
    else
      b.spinning(link(b), reaction->pin_radius, name, bound, regularisation);
  }
};

}  // namespace freeplay
