// Transformations of a scene: mirrored, in other units, in another order; and a nearly identical
// scene.
#pragma once

#include "mechanism/scene.hpp"

namespace freeplay::verification::random_scenes {

/// Its beams by pieces, as if these and their elements were stated, with their start; without beams the same
/// scene. The other transformations do not change mechanism.beams.
Scene by_pieces(Scene scene);

/// Mirrored, x → −x: the same motion, mirrored.
Scene mirrored(Scene scene);

/// Rotated about the origin by this angle (rad): the same motion, rotated. The ground may have
/// revolute joints and planes; for drives and other elements there it throws std::logic_error.
Scene turned(Scene scene, double angle);

/// In other units: lengths, masses and times of the scene multiplied by these. Powers of two change
/// no digit in arithmetic without absolute constants.
struct Units {
  double length = 1, mass = 1, time = 1;
};
Scene rescaled(Scene scene, const Units& units);

/// Bodies, joints, contacts, drives and loads in the opposite order.
Scene reordered(Scene scene);

/// Changes every parameter that the constraints leave free by up to `share` of itself; `which`
/// selects one of the variants.
Scene nudged(Scene scene, double share, int which);

}  // namespace freeplay::verification::random_scenes
