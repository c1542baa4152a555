// Dynamics of mechanism/elements/cam_contact.hpp, which states the equations.
#pragma once

#include "dynamics/cam_pairs.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/cam_contact.hpp"

namespace freeplay {

template <>
struct Dynamics<CamContact> : CamContact {
  void build(auto& b) const {
    const auto profile = this->profile();
    const auto curve = curvature(profile);
    auto facts = b.facts(name, between, surface);
    // Flat face: radius of the outline. Roller: reduced radius of two discs, where the outline's
    // radius is that of the pitch curve minus the roller's.
    facts.radius = follower == Follower::flat ? curve.round
                                              : roller_radius * (curve.round - roller_radius) / curve.round;
    facts.clearance = 1e-3 * facts.radius;  // scale for tolerances
    b.limit_turn(table.empty() ? profile.narrowest() / 8 : profile.narrowest() / 2);
    const auto link = b.link(between, at);
    if (follower == Follower::flat)
      b.pair(CamFlatPair{link, axis, base_radius, profile}, facts);
    else
      b.pair(
          CamRollerPair{
              link, roller_radius, curve.round, curve.hollow, {base_radius + roller_radius, profile}},
          facts);
  }
};

}  // namespace freeplay
