// Dynamics of mechanism/elements/plane_contact.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/plane_contact.hpp"

namespace freeplay {

template <>
struct Dynamics<PlaneContact> : PlaneContact {
  void build(auto& b) const {
    auto facts = b.facts(name, between, surface);
    facts.radius = radius;
    facts.stiffness = stiffness;
    facts.arm = b.longest_arm();
    if (std::max(radius, facts.arm) == 0) facts.arm = b.span();
    facts.clearance = 1e-3 * std::max(radius, facts.arm);  // scale for tolerances
    b.line(b.link(between, at), 1, axis, radius, radius, facts);
  }
};

}  // namespace freeplay
