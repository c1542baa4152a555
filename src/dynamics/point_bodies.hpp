// Point bodies: masses without rotation. They have no inertia, no directions and no place but their centre. In a System the
// angle of each is held at zero by a row of its own, which no other element shares: every element acts at the centre, and
// exerts no moment about it.
#pragma once

namespace freeplay {

struct Mechanism;

/// Throws ModelError, which names the key, where an element would exert a moment on a point body, act off its centre, or take
/// a direction or an angle from it.
void check_point_bodies(const Mechanism& mechanism);

}  // namespace freeplay
