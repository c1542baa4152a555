// An angle whose torque table has kinks, as integrators see it: between two of them the torque is smooth.
#pragma once

#include <cmath>
#include <vector>

#include "model/kinematics.hpp"

namespace freeplay {

struct Phase {
  static constexpr double turn = 6.283185307179586;
  Link link;
  std::vector<double> kinks;  ///< rad, increasing, within one turn; not empty

  /// The piece that an angle is on; where it stands on a kink (to rounding), the one above or below.
  Piece piece(double angle, bool above) const {
    const double rounding = 1e-12 * std::fmax(1, std::abs(angle));
    const double from = above ? angle + rounding : angle - rounding;
    const double turns = std::floor((from - kinks.front()) / turn);
    const double x = from - turn * turns;
    std::size_t i = 0;
    while (i < kinks.size() && kinks[i] <= x) ++i;
    // The kinks before and after x, over the ends of the turn.
    const double low = i > 0 ? kinks[i - 1] : kinks.back() - turn;
    const double high = i < kinks.size() ? kinks[i] : kinks.front() + turn;
    return {low + turn * turns, high + turn * turns};
  }
};

}  // namespace freeplay
