// The phase plane of a body: which of its coordinates is drawn against its rate, and the titles of the axes.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "plots/drawing/axis.hpp"

namespace freeplay::plots {

/// The coordinate to draw: 0 x, 1 y, 2 angle; −1 if none of them moves. It is the angle, or x or y if the
/// body rotates fully or not at all. `m`: x, y, theta, vx, vy, omega of the rows.
int phase_coordinate(const std::array<std::vector<double>, 6>& m);

/// The values of a coordinate k (0 x, 1 y, 2 angle) and its rate in fitting units, with their titles.
struct PhasePlane {
  ShownUnit place_unit, rate_unit;
  AxisTitle place, rate;
};
PhasePlane phase_plane(const std::array<std::vector<double>, 6>& motion, std::size_t k);

}  // namespace freeplay::plots
