// Point bodies: masses without rotation. They have no inertia, no directions and no points besides
// their centre. In a System a separate constraint row fixes the angle of each at zero. No other
// element uses that angle: every element acts at the centre and exerts no moment about it.
#pragma once

namespace freeplay {

struct Mechanism;

/// Throws ModelError, which names the key, if an element exerts a moment on a point body, acts off
/// its centre, or uses its direction or angle.
void check_point_bodies(const Mechanism& mechanism);

}  // namespace freeplay
