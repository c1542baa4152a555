// What the parts of the claim set "gears" share: ways to run its scenes, and what blows are held to.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/gears.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

namespace freeplay::verification::gear_claims {

// The parts, in the order of the set.
void rattle(Findings& f);
void reactions(Findings& f);  ///< an ideal pair under torques: along the line of action, either flank
void planet(Findings& f);  ///< sun, planet on a carrier, fixed ring: the carrier's speed by Willis' formula
void distance(
    Findings& f);  ///< a wheel whose centre swings: the involute's relation between distance and angles
void racks(Findings& f);
void slots(Findings& f);
void stops(Findings& f);
void bumps(Findings& f);  ///< a block against a damped spring that cannot pull, and a lever likewise

inline constexpr double alpha = 20 * M_PI / 180;

/// A way, and what it can be held to.
struct Way : test::Way {
  double speeds;  ///< relative error of speeds and impulses
  const char* reason;
};
extern const std::array<Way, 4> ways;

Scene scene_by(const std::string& text, const Way& way);
/// Blows of a run against those of a closed form: each one's impulse and approach, and its time.
void blows(Findings& f, const std::string& what, const Way& way, const Result& run,
           const std::vector<reference::Blow>& exact, double e);
/// Forces at the end of the third step, by name.
ElementForce force_of(const Scene& scene, Family family, const std::string& name);

/// Keys of teeth with backlash.
inline constexpr const char* loose_teeth = "backlash = 1e-4\nmesh_stiffness = 2e10\nsurface = \"steel\"\n";

}  // namespace freeplay::verification::gear_claims
