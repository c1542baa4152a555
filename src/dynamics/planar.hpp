// The coordinates of a planar mechanism: of each body in turn the place x, y of its centre of mass (m) and its
// angle θ (rad), in world axes; rates and accelerations stand in the same order. That a body has three of them is
// known here and to the files of model/ alone. Nothing but the standard library.
#pragma once

#include <array>
#include <concepts>

#include "values/vec2.hpp"

namespace freeplay::planar {

/// How many coordinates a body has.
inline constexpr int coordinates = 3;
/// What a coordinate, its rate and its acceleration are called in result files.
inline constexpr std::array<const char*, coordinates> names{"x", "y", "theta"},
    rate_names{"vx", "vy", "omega"}, acceleration_names{"ax", "ay", "alpha"};

/// The first coordinate of a body; of the body behind the last: how many there are.
constexpr auto first(std::integral auto body) { return coordinates * body; }
constexpr auto body_of(std::integral auto coordinate) { return coordinate / coordinates; }
/// Its name within its body.
constexpr const char* name(int coordinate) { return names[coordinate % coordinates]; }

/// @name Of a body that moves, from the coordinates q or rates v of all
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
