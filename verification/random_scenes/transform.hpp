// Transformations of a scene: mirrored, in other units, in another order; and a nearly identical
// scene.
#pragma once

#include "mechanism/scene.hpp"

namespace freeplay::verification::random_scenes {

/// Seen in a mirror, x → −x: the same motion, mirrored.
Scene mirrored(Scene scene);

/// Turned about the origin by this angle (rad): the same motion, turned. On the ground there may be revolute joints and
/// planes; for drives and other elements there it throws std::logic_error.
Scene turned(Scene scene, double angle);

/// In other units: lengths, masses and times of the scene times these. Powers of two change no digit of an arithmetic
/// without absolute constants.
struct Units {
  double length = 1, mass = 1, time = 1;
};
Scene rescaled(Scene scene, const Units& units);

/// Bodies, joints, contacts, drives and loads in the opposite order.
Scene reordered(Scene scene);

/// Every fact that constraints leave free changed by up to `share` of itself; `which` chooses one of the ways.
Scene nudged(Scene scene, double share, int which);

}  // namespace freeplay::verification::random_scenes
