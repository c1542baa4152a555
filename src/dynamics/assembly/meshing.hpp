// Positions and phases of toothed bodies whose scene does not state where they are.
//
// Gears and racks hold no distance: other joints place their centres. If the given positions do not
// bring all teeth into mesh, or if none is given, the other joints are closed first, without teeth.
// The teeth mesh in that pose: absent phases (mechanism/elements/gear_joint.hpp) follow from it,
// and the assembly of all joints starts from it.
#pragma once

#include <vector>

#include "values/stop.hpp"

namespace freeplay {

struct Mechanism;

/// Whether the teeth of all gears and racks are in mesh at q. Positions that are all zero, with
/// open joints, count as not stated.
bool in_mesh(const Mechanism& mechanism, const std::vector<double>& q);

/// The pose, from rough positions q, in which all joints but gears and racks are closed and have no
/// clearance; q itself if there is none.
std::vector<double> pose_without_teeth(const Mechanism& mechanism, std::vector<double> q,
                                       const StopToken& stop = {});

/// Sets each absent phase, so that the teeth are centred in the gaps at the bodies' positions, or
/// at pose_without_teeth() if those are not in mesh. Throws ModelError if the teeth are out of mesh
/// there, too.
void set_phases(Mechanism& mechanism);

}  // namespace freeplay
