// Dynamics of mechanism/elements/gear_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/mesh.hpp"
#include "dynamics/rows/turn.hpp"
#include "mechanism/elements/gear_joint.hpp"

namespace freeplay {

/// The row of an ideal pair of teeth, or a contact for each flank. `radius` (m): of Hertz's contact.
/// `rub(link, c)` adds the friction of an ideal pair with these c₁ and c₂.
template <class Mesh>
void build_teeth(auto& b, const auto& joint, double radius, auto rub) {
  const auto link = b.link(joint.between, joint.at);
  if (!joint.clearance) {
    b.mesh(link, Mesh{joint.mesh(side_of(joint.flank), 0)}, joint.name);
    if (joint.loss.any()) rub(link, joint.loss.shares());
    return;
  }
  const auto& c = *joint.clearance;
  for (const auto side : {Flank::forward, Flank::backward}) {
    auto facts = b.facts(joint.name + "." + std::string(text_of(side)), joint.between, c.surface);
    facts.clearance = 0.5 * c.normal;
    facts.has_clearance = true;
    facts.radius = radius;
    facts.stiffness = c.stiffness;
    b.flank(link, Mesh{joint.mesh(side_of(side), c.normal)}, facts);
  }
}

/// A rate (rad/s) as the speed (m/s) at a radius.
inline std::optional<double> speed_at(std::optional<double> rate, double radius) {
  if (rate) *rate *= radius;
  return rate;
}

template <>
struct Dynamics<GearJoint> : GearJoint {
  void build(auto& b) const {
    if (!phase) return;
    for (const int which : {0, 1})
      if (between[which] != ground) b.reach(pitch(which));
    const double kind = internal ? -1 : 1, r0 = pitch(0), r1 = pitch(1);
    const auto rub = [&](const auto& link, const auto& c) {
      // The mesh turns wheel 1 by σ r λ. It drives where this opposes its rotation, like friction.
      const bool drives = flank == Flank::forward;
      const double base = std::cos(pressure_angle) * r0;
      b.friction(TurnRow{link, base}, {name, 0, speed_at(loss.regularisation, base),
                                       b.mesh_bound(drives ? c[0] : c[1], drives ? c[1] : c[0])});
    };
    build_teeth<InvoluteMesh>(b, *this, std::sin(pressure_angle) * r0 * r1 / (r0 + kind * r1), rub);
  }
};

}  // namespace freeplay
