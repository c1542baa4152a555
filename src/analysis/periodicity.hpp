// Periodicity of a mechanism: the period of its explicit dependence on time, which is one turn of a drive
// with constant speed or the period of a curve against time, and shifts that leave the mechanism unchanged.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "numerics/dense.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Mechanism;
class System;

/// Period of the explicit dependence on time.
struct Excitation {
  bool any = false;   ///< whether the equations depend on time
  double period = 0;  ///< s; 0: none found
  std::string why;    ///< reason why none was found
};

/// Of several periods, it is the longest one if the others are its divisors.
Excitation excitation_of(const Mechanism& mechanism, const System& system);

/// The period of the section (s): that of the excitation, else the given one. Throws ModelError if neither is
/// known or both differ.
double section_period(const Excitation& excitation, const std::optional<double>& given);

// Symmetry under which a motion may be periodic: a common shift of named coordinates, as that of the
// heights of all bodies of a toy that descends a uniform pole (docs/theory/orbits.md).

/// The displacements of q for coordinates by the names of trajectory.csv (BODY.x, BODY.y, BODY.theta),
/// or "x" or "y" for those of all bodies. Throws ModelError if a name is unknown.
Eigen::VectorXd shift_of(const Mechanism& mechanism, const std::vector<std::string>& coordinates);

/// What changes if q is shifted at a state: empty if constraints, contacts and forces do not.
std::string changes_with_shift(const System& system, const Eigen::VectorXd& shift, const State& s);

}  // namespace freeplay
