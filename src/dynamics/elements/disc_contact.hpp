// Dynamics of mechanism/elements/disc_contact.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/disc_contact.hpp"

namespace freeplay {

template <>
struct Dynamics<DiscContact> : DiscContact {
  void build(auto& b) const {
    const auto [Ri, Rj] = radii;
    auto facts = b.facts(name, between, surface);
    facts.radius = Ri * Rj / (Ri + Rj);
    facts.clearance = 1e-3 * facts.radius;  // scale for tolerances
    b.round(b.link(between, at), -1, Ri + Rj, Ri, -Rj, facts);
  }
};

}  // namespace freeplay
