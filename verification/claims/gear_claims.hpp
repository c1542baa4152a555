// Shared by the parts of the claim set "gears": ways to run its scenes, and the claims on a
// sequence of impacts.
#pragma once

#include "verification/claims/claim.hpp"
#include "verification/references/gears.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::gear_claims {

// The parts, in the order of the set.
void rattle(Findings& f);
/// an ideal pair under torques: force along the line of action, either flank
void reactions(Findings& f);
/// sun, planet on a carrier, fixed ring: the carrier's speed by Willis' formula
void planet(Findings& f);
/// A wheel with an oscillating centre: the involute's relation between centre distance and angles.
void distance(Findings& f);
void racks(Findings& f);
void slots(Findings& f);
void stops(Findings& f);
void bumps(Findings& f);  ///< a block, and a lever, against a damped spring that cannot pull

inline constexpr double alpha = 20 * M_PI / 180;

/// A way to run a scene, and the accuracy that is claimed of it.
struct Way : test::Way {
  double speeds;  ///< bound of the relative error of speeds and impulses
  const char* reason;
};
extern const std::array<Way, 4> ways;

/// The way as the scheme of a claim's name; `step` (s) as text, where the way has fixed steps.
std::string scheme_of(const Way& way, const char* step);

Scene scene_by(Scene scene, const Way& way);
Scene scene_by(const std::string& text, const Way& way);
/// Adds the claims on impulse, approach speed and time of each impact of a run against a closed
/// form.
void impacts(Findings& f, const char* subject, const Way& way, const std::string& scheme, const Result& run,
             const std::vector<reference::BounceImpact>& exact, double e);
/// Forces at the end of the third step, by name.
ElementForce force_of(const Scene& scene, Family family, const std::string& name);

/// Keys of teeth with backlash.
inline constexpr const char* loose_teeth = "backlash = 1e-4\nmesh_stiffness = 2e10\nsurface = \"steel\"\n";

}  // namespace freeplay::verification::gear_claims
