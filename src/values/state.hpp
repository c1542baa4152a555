// The state of a mechanism.
#pragma once

#include <vector>

namespace freeplay {

struct State {
  double t = 0;           ///< s
  std::vector<double> q;  ///< m, rad: x, y and θ of each body, in the mechanism's order
  std::vector<double> v;  ///< m/s, rad/s, likewise
  /// First-order states of elements (a motor's current, a governor's integral), in the elements' order and
  /// units; none unless an element has one.
  std::vector<double> z;
};

}  // namespace freeplay
