// Velocities of a start: G v + Φ_t = 0 at its positions (stated.hpp).
#pragma once

#include <vector>

#include "dynamics/assembly/closure.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Mechanism;
class System;

/// Completes the velocities of s at its positions. `stated` ones are kept, or change by the least
/// mass-weighted amount if they contradict the constraints; the others change least from those in s.
/// Returns the row that the stated velocities violate most (m/s, rad/s). Throws ModelError if no
/// velocities satisfy all rows.
OpenJoint assemble_velocities(const Mechanism& mechanism, const System& system,
                              const std::vector<char>& stated, State& s);

}  // namespace freeplay
