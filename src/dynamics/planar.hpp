// Coordinates of a planar mechanism: for each body in turn the position x, y of its centre of mass
// (m) and its angle θ (rad), in world axes. Rates and accelerations have the same order. Only this
// file and the sources of src/dynamics know that a body has three coordinates.
#pragma once

#include <array>
#include <concepts>

#include "values/vec2.hpp"

namespace freeplay::planar {

/// Number of coordinates of a body.
inline constexpr int coordinates = 3;
/// Names of a coordinate, its rate and its acceleration in result files.
inline constexpr std::array<const char*, coordinates> names{"x", "y", "theta"},
    rate_names{"vx", "vy", "omega"}, acceleration_names{"ax", "ay", "alpha"};

/// Index of the first coordinate of a body; for the number of bodies, the number of coordinates.
constexpr auto first(std::integral auto body) { return coordinates * body; }
constexpr auto body_of(std::integral auto coordinate) { return coordinate / coordinates; }
/// Name of a coordinate within its body.
constexpr const char* name(int coordinate) { return names[coordinate % coordinates]; }

/// @name Coordinates and rates of a moving body, from those of all bodies, q or v
///@{
inline Vec2 position(const double* q, std::integral auto body) {
  return {q[first(body)], q[first(body) + 1]};
}
inline double angle(const double* q, std::integral auto body) { return q[first(body) + 2]; }
inline Vec2 velocity(const double* v, std::integral auto body) {
  return {v[first(body)], v[first(body) + 1]};
}
inline double rate(const double* v, std::integral auto body) { return v[first(body) + 2]; }
///@}

}  // namespace freeplay::planar
