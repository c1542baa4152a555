// Derivatives of results of a run with respect to keys of its scene or its initial state.
#pragma once

#include <cmath>
#include <string>
#include <vector>

namespace freeplay {

/// One quantity with its derivatives with respect to all requested keys.
struct Sensitivity {
  /// as requested: event.1.t, end.ball.vy, energy.dissipated_in_contacts
  std::string name;
  /// in SI units; NaN if the run does not reach it
  double value = NAN;
  /// in SI units, one for each key; NaN where there is none
  std::vector<double> derivatives;
  /// for each key, the reason why there is no derivative; empty if there is one
  std::vector<std::string> reasons;
};

/// All results of a sensitivity run.
struct Sensitivities {
  /// keys as requested
  std::vector<std::string> keys;
  /// value of each key, SI
  std::vector<double> key_values;
  /// in the order of the request
  std::vector<Sensitivity> quantities;
  /// Cost of the variational equations as a multiple of that of the run: evaluations of the right-hand
  /// side, each direction of a derivative counted as one.
  double cost = 0;
  /// reason why the run stopped before its end; empty if it did not
  std::string stopped;
};

}  // namespace freeplay
