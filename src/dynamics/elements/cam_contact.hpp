// Dynamics of mechanism/elements/cam_contact.hpp; the equations stand there.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/pairs/cam_flat.hpp"
#include "dynamics/pairs/cam_roller.hpp"
#include "mechanism/elements/cam_contact.hpp"

namespace freeplay {

template <>
struct Dynamics<CamContact> : CamContact {
  void build(auto& b) const {
    const auto profile = this->profile();
    const auto curve = curvature(profile);
    auto facts = b.facts(name, between, surface);
    // Of a face on the outline; of two discs, the outline's radius being less than the pitch curve's by the roller's.
    facts.radius = follower == Follower::flat ? curve.round
                                              : roller_radius * (curve.round - roller_radius) / curve.round;
    facts.clearance = 1e-3 * facts.radius;  // a scale for tolerances
    b.limit_turn(table.empty() ? profile.narrowest() / 8 : profile.narrowest() / 2);
    const auto link = b.link(between, at);
    if (follower == Follower::flat)
      b.pair(CamFlatPair{link, axis, base_radius, profile}, facts);
    else
      b.pair(
          CamRollerPair{link, base_radius + roller_radius, roller_radius, curve.round, curve.hollow, profile},
          facts);
  }
};

}  // namespace freeplay
