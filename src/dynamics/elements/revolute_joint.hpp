// Dynamics of mechanism/elements/revolute_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/revolute_joint.hpp"

namespace freeplay {

template <>
struct Dynamics<RevoluteJoint> : RevoluteJoint {
  void build(auto& b) const {
    const auto link = b.link(between, at);
    if (!clearance) return b.points(link, name);
    const auto& c = *clearance;
    const double journal = c.bearing_radius - c.radial;
    auto facts = b.facts(name, between, c.surface);
    facts.clearance = c.radial;
    facts.has_clearance = true;
    facts.radius = c.bearing_radius * journal / c.radial;
    facts.ring = true;
    facts.radius_bearing = c.bearing_radius;
    facts.radius_journal = journal;
    facts.bearing_length = c.bearing_length;
    if (c.lubricant >= 0) facts.lubricant = b.mechanism().lubricants[c.lubricant];
    if (const auto surfaces = out_of_round(b.mechanism(), *this)) return b.profiled(link, *surfaces, facts);
    b.round(link, 1, c.radial, c.bearing_radius, journal, facts);
  }
};

}  // namespace freeplay
