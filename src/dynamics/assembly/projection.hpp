// Projection of a state near the constraints onto them, at its own time: Newton steps of least
// mass-weighted length onto Φ(q, t) = 0, then the least mass-weighted change of the velocities onto
// G v + Φ_t = 0.
#pragma once

namespace freeplay {

struct State;
class System;

/// Returns false if the positions do not converge; the state is then to be discarded.
bool project_onto_constraints(const System& system, State& state);

}  // namespace freeplay
