// Beams at the start. The bodies at the ends are assembled as if beams were rigid, if that is possible. The pieces of a
// beam without stated positions lie on the cubic curve (Hermite) through its ends with its tangents there, and move
// with it; those of a beam with a free end lie on its unloaded arc and move with the body at the other end, those of a
// reduced beam lie on its static deflection.
#pragma once

#include "mechanism/mechanism.hpp"
#include "values/state.hpp"

namespace freeplay {

/// The mechanism with a rigid joint of the bodies at its ends in place of each beam, none of one with a free end.
Mechanism with_rigid_beams(Mechanism mechanism);

/// Places the pieces that state no position in s.q.
void place_beams(const Mechanism& mechanism, State& s);
/// Sets the velocities of the pieces that state none, from those of the bodies at the ends.
void move_beams(const Mechanism& mechanism, State& s);

}  // namespace freeplay
