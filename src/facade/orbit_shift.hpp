// Symmetry under which a motion may be periodic: a common shift of named coordinates, as that of the
// heights of all bodies of a toy that descends a uniform pole (docs/theory/orbits.md).
#pragma once

#include <string>
#include <vector>

#include "numerics/dense.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Mechanism;
class System;

/// The displacements of q for coordinates by the names of trajectory.csv (BODY.x, BODY.y, BODY.theta),
/// or "x" or "y" for those of all bodies. Throws ModelError if a name is unknown.
Eigen::VectorXd shift_of(const Mechanism& mechanism, const std::vector<std::string>& coordinates);

/// What changes if q is shifted at a state: empty if constraints, contacts and forces do not.
std::string changes_with_shift(const System& system, const Eigen::VectorXd& shift, const State& s);

}  // namespace freeplay
