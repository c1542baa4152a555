// Dynamics of mechanism/elements/freewheel.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/rows/spin.hpp"
#include "mechanism/elements/freewheel.hpp"

namespace freeplay {

template <>
struct Dynamics<Freewheel> : Freewheel {
  auto link(auto& b) const { return b.free_link(between, {}); }
  void build(auto& b) const {
    const auto on = link(b);
    const double arm = b.gyration(on);  // m, at which speed and force of its row are
    auto bound = ReactionBound::fixed(torque_limit / arm);
    bound.ways[direction == Free::forward ? 1 : 0] = 0;
    auto speed = regularisation;
    if (speed) *speed *= arm;
    b.friction(SpinRow{on, arm}, {name, 0, speed, bound});
  }
};

}  // namespace freeplay
