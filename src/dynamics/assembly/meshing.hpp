// Positions and phases of toothed bodies whose scene does not state where they are.
//
// Gears and racks hold no distance: other joints place their centres. If the given positions do not
// bring all teeth into mesh, or if none is given, the other joints are closed first, without teeth.
// The teeth mesh in that pose: absent phases (mechanism/elements/gear_joint.hpp) follow from it,
// and the assembly of all joints starts from it.
#pragma once

#include <optional>
#include <string>
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

/// The teeth of a pair of gears at a distance of its centres, or of a gear whose centre is at a height h
/// above the pitch line of its rack. With standard tips, one module m beyond the pitch circles and line,
/// the contact ratio of external gears (ISO 21771-1:2007), and of a gear and a rack, is
///
///     ε = (√(r_a1² − r_b1²) + √(r_a2² − r_b2²) − √(a² − S²)) / p_b,
///     ε = (√(r_a² − r_b²) − r sin α + min((m − h + r)/sin α, r sin α)) / p_b.
///
/// The second one is the limit of the first for r₂ → ∞. Contact on the rack ends at the latest where the line
/// of action touches the base circle, r sin α from the pitch point; tips of the rack beyond it undercut.
struct TeethAtDistance {
  std::string name;                       ///< of the joint
  bool rack = false;                      ///< a gear and a rack
  bool ideal = true;                      ///< whether it has no backlash
  double distance = 0, standard = 0;      ///< m, of the centres; of a rack h, and r
  double apart = 0;                       ///< m, of the tips; negative while they overlap
  double play = 0;                        ///< m, sum of the gaps of both flanks
  std::optional<double> contact_ratio{};  ///< if the numbers of teeth are given
};
/// Those of all pairs in mesh at q. Pitch circles without numbers of teeth, or module, have the tips of six
/// teeth on the smaller one.
std::vector<TeethAtDistance> teeth_at(const Mechanism& mechanism, const std::vector<double>& q);

/// Throws ModelError if the tips of an ideal pair do not overlap at q: its constraint would act through
/// the air.
void require_mesh(const Mechanism& mechanism, const std::vector<double>& q);

}  // namespace freeplay
