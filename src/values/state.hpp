// The state of a mechanism: time, coordinates, velocities and first-order states.
#pragma once

#include <vector>

namespace freeplay {

/// State of a mechanism (shapes: freeplay.hpp).
struct State {
  double t = 0;           ///< s
  std::vector<double> q;  ///< m, rad: x, y and θ of each body, in the mechanism's order
  std::vector<double> v;  ///< m/s, rad/s: their rates
  /// First-order states of elements (a motor's current, a governor's integral), in the order and
  /// units of the elements; empty if no element has one.
  std::vector<double> z;
};

}  // namespace freeplay
