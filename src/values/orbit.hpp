// A periodic motion of a mechanism.
#pragma once

#include <cmath>
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "values/state.hpp"

namespace freeplay {

/// Onset of a contact within a periodic motion.
struct OrbitImpact {
  double t = 0;       ///< s
  std::string joint;  ///< joint with clearance or contact
  double speed = 0;   ///< m/s, approach speed
};

/// A contact that is closed during the whole motion.
struct OrbitContact {
  std::string joint;       ///< joint with clearance or contact
  double least_force = 0;  ///< N, least normal force
  double t = 0;            ///< s, when it has it
  /// m/s, v₀ of the law of a penalty run, if the contact keeps it during the whole motion
  std::optional<double> v0 = {};
};

/// A periodic motion, or the reason why none was found.
struct Orbit {
  double period = 0;  ///< s, of the drive; without a drive, of the motion over `periods`
  int periods = 1;    ///< number of periods after which the state returns
  /// Greatest change of a coordinate, rate or first-order state over the periods, relative to its error
  /// scale (docs/theory/orbits.md); of the last iterate if there is a failure.
  double residual = NAN;
  /// Likewise the greatest change of the end of the motion if time stepping makes finer steps, which
  /// limits the residual; 0 if it makes none.
  double step_error = 0;
  State state;       ///< at the section
  double moved = 0;  ///< s, by which the section was moved away from a contact onset
  double shift = 0;  ///< m or rad, change of the coordinates of OrbitRequest::shift
  /// contact onsets within the periods, in the order of time
  std::vector<OrbitImpact> impacts;
  /// contacts that last during the whole motion; not of time stepping
  std::vector<OrbitContact> lasting;
  /// Floquet multipliers of the mechanism's own degrees of freedom, largest modulus first; in penalty runs
  /// also of the retained data of contacts (docs/theory/orbits.md)
  std::vector<std::complex<double>> multipliers;
  bool stable = false;  ///< whether all multipliers are inside the unit circle
  int iterations = 0;   ///< of Newton's method
  std::string failure;  ///< why no periodic motion was found; empty if one was
};

}  // namespace freeplay
