// Projection of a state near the constraints onto them, at its own time. Chosen contacts stay closed,
// like constraints. With C = (Φ, g) and the rows R = ∂C/∂q: Newton steps of least mass-weighted length
// onto C(q, t) = 0, then the least mass-weighted change of the velocities onto R v + ∂C/∂t = 0.
#pragma once

#include <vector>

#include "numerics/dense.hpp"

namespace freeplay {

struct State;
class System;

/// M^(−1/2) Rᵀ at a state; its columns belong to the rows of the system and then to the contacts.
Eigen::MatrixXd weighted_rows(const System& system, const std::vector<int>& contacts, const State& state);

/// Returns false if the positions do not converge; the state is then to be discarded.
bool project_onto_constraints(const System& system, const std::vector<int>& contacts, State& state);

}  // namespace freeplay
