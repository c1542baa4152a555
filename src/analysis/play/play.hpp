// Output play: how far outputs of a mechanism can be from their ideal values because of clearances, over
// positions of a driven joint, with the drives held at each position (loose_mechanism.hpp,
// play_extremes.hpp).
//
// The linear range is ± Σ_k |∂y/∂u_k|. A joint's part of the exact range follows from its gradient at the
// ideal position and at the extreme, ½ (a_k(0) + a_k(u*))·u*_k, scaled so that the parts sum to the range.
// With journals distributed uniformly on their discs, and other play uniformly between its ends, a joint's
// part of the variance is |a_k|²/4 or a_k²/3 to first order.
//
// Garrett and Hall, J. Eng. Ind. 91 (1969) 198, describe mobility bands of linkages with clearance; Chen, Wang
// and Lin, Mech. Mach. Theory 64 (2013) 1, the exact range of planar parallel manipulators.
//
// Usage:
//
//     const auto play = freeplay::find_play(
//         scene, {.quantities = {"rocker.theta"}, .over = "A", .from = 0, .to = 6.28});
//     for (const auto& p : play.positions)
//       if (p.refusal.empty()) use(p.coordinate, p.ranges[0].least, p.ranges[0].greatest);
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "values/play.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// Outputs and positions of find_play().
struct PlayOptions {
  /// BODY.x, BODY.y, BODY.theta, BODY.POINT.x, BODY.POINT.y, a joint's name, or "distance(P, Q)" with points BODY,
  /// BODY.POINT or ground
  std::vector<std::string> quantities = {};
  std::string over = {};       ///< a joint with prescribed motion; empty: the position of the start
  double from = 0;             ///< its first angle (rad) or position (m)
  double to = 0;               ///< its last angle or position
  int points = 73;             ///< number of positions, ends included, ≥ 1
  bool loads = false;          ///< also the equilibrium under the loads at each position
  PlaySampling sampling = {};  ///< samples > 0: also quantiles
  /// Stop request; the function then throws Interrupted.
  StopToken stop = {};
};

/// The ranges of the outputs at all positions. Throws ModelError for wrong options, unknown names, undriven motions,
/// dependent constraints, positions that the mechanism cannot reach, and if no position has a range.
Play find_play(const Scene& scene, const PlayOptions& options);

/// Sums a list of the components, such as PlayRange::parts, by joint, in the order of the components.
std::vector<std::pair<std::string, double>> by_joint(const Play& play, const std::vector<double>& parts);

/// The widest range of each quantity in a sentence, with the joints' shares.
std::vector<std::string> verdicts(const Play& play);

}  // namespace freeplay
