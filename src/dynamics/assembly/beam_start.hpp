// Beams at the start: the pieces of a beam without stated positions lie on the cubic curve (Hermite) through its ends
// with its tangents there, and move with it.
#pragma once

#include "values/state.hpp"

namespace freeplay {

struct Mechanism;

/// Places the pieces that state no position in s.q.
void place_beams(const Mechanism& mechanism, State& s);
/// Sets the velocities of the pieces that state none, from those of the bodies at the ends.
void move_beams(const Mechanism& mechanism, State& s);

}  // namespace freeplay
