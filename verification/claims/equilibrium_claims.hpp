// Shared by the parts of the claim set "equilibrium": an equilibrium with its eigenmodes, and
// scenes.
#pragma once

#include "dynamics/assembly/modes.hpp"
#include "dynamics/system.hpp"
#include "values/family.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/small_motions.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::equilibrium_claims {

// The parts, in the order of the set.
void pendulums(Findings& f);
void springs(Findings& f);
void slider_crank(Findings& f);
void lamp(Findings& f);
void contacts(Findings& f);
void stays(Findings& f);  ///< runs that start at equilibrium

using std::sqrt;
inline constexpr double pi = std::numbers::pi;
inline constexpr const char* exact =
    "derivatives are exact: rounding of position and values, 1e-13, margin of 1000";
/// Hertz's K of steel on steel at a radius of curvature (m), from the formula.
inline double hertz(double radius) { return 4.0 / 3 * 207e9 / (2 * (1 - 0.3 * 0.3)) * sqrt(radius); }

struct Rest {
  Equilibrium at;
  std::vector<Mode> modes;
  Forces forces;
  /// Angular frequency of the i-th oscillating mode (rad/s).
  double rate(std::size_t i) const {
    for (const auto& m : modes)
      if (m.kind == Mode::Kind::swing && i-- == 0) return std::abs(m.s);
    return NAN;
  }
};

Rest rest(const Scene& scene, Family family);
/// Of a scene of verification/scenes.
Rest rest(const char* scene, Family family = Family::nonsmooth);

reference::SprungSliderCrank sprung();
Scene sprung_scene(bool clearance_joint);

}  // namespace freeplay::verification::equilibrium_claims
