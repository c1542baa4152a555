// Dynamics of mechanism/elements/joint_friction.hpp, which states the equations.
#pragma once

#include <utility>

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/rows/sliding.hpp"
#include "dynamics/rows/spin.hpp"
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
    if (!reaction) return build_fixed(b);
    const auto* guide = std::get_if<TranslationalJoint>(&b.mechanism().joints[joint]);
    auto bound = b.reaction_bound(joint);
    static_cast<StribeckCurve&>(bound) = reaction->peak.curve(reaction->friction);
    if (guide && reaction->slider_length) bound.couple = 2 / *reaction->slider_length;
    if (guide)
      b.friction(SlidingRow{link(b), guide->axis}, {name, 0, regularisation, bound});
    else
      b.friction(SpinRow{link(b), reaction->pin_radius}, {name, 0, regularisation, bound});
  }

 private:
  void build_fixed(auto& b) const {
    const auto* guide = std::get_if<TranslationalJoint>(&b.mechanism().joints[joint]);
    const auto on = link(b);
    const double arm = guide ? 1 : b.gyration(on);  // m, of a torque
    auto speed = regularisation;
    if (speed) *speed *= arm;
    const double sliding = guide ? *force : *torque / arm;
    FrictionFacts facts{name, sliding, speed};
    if (peak) {
      auto bound = ReactionBound::fixed(sliding);
      bound.more = peak->bound / arm - sliding;
      bound.stribeck = peak->stribeck_speed * arm;
      bound.exponent = peak->stribeck_exponent.value_or(bound.exponent);
      facts = {name, 0, speed, bound};
    }
    if (guide)
      b.friction(SlidingRow{on, guide->axis}, std::move(facts));
    else
      b.friction(SpinRow{on, arm}, std::move(facts));
  }
};

}  // namespace freeplay
