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
#pragma once

#include <Eigen/Core>

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/play/play_statistics.hpp"
#include "values/stop.hpp"
#include "values/table.hpp"

namespace freeplay {

struct Scene;

struct PlayOptions {
  std::vector<std::string> quantities = {};  ///< output_quantity()
  std::string over = {};       ///< a joint with prescribed motion; empty: the position of the start
  double from = 0, to = 0;     ///< its angle (rad) or position (m)
  int points = 73;             ///< number of positions, ends included
  bool loads = false;          ///< also the equilibrium under the loads at each position
  PlaySampling sampling = {};  ///< samples > 0: also quantiles
  StopToken stop = {};
};

/// Range of one output at one position.
struct PlayRange {
  double ideal = 0, linear = 0;  ///< value without clearances; Σ |a_k|
  double least = 0, greatest = 0, bound_least = 0, bound_greatest = 0;
  std::vector<double> parts;  ///< of the components in greatest − least
  /// of the components and the tolerances in the variance to first order; they sum to 1
  std::vector<double> variance;
  Eigen::VectorXd at_least, at_greatest;  ///< poses q
  bool settled = true;                    ///< whether both searches converged
  std::optional<PlayQuantiles> quantiles;
  double width() const { return greatest - least; }
  /// Σ of both differences of bounds and values found, relative to the width.
  double gap() const;
};

/// Equilibrium under the loads at one position (dynamics/assembly/equilibrium.hpp).
struct LoadedPose {
  std::string failure;  ///< why there is none; empty: there is one
  Eigen::VectorXd q;
  std::vector<double> values;     ///< of the quantities
  std::vector<double> reactions;  ///< fx, fy (N) and m (N m) of each element of Play::reactions
};

struct PlayPosition {
  double coordinate = 0;  ///< of the driven joint, rad or m
  std::string refusal;    ///< why no range is given; empty: `ranges` has one for each quantity
  std::vector<PlayRange> ranges;
  Eigen::VectorXd pose;  ///< ideal
  LoadedPose up, down;   ///< approached from the position before, and from the next one
};

/// A journal or tooth that changes sides between two neighbouring positions.
struct PlayJump {
  std::string joint;
  double from = 0, to = 0;  ///< coordinates, in the order of the approach
  bool up = true;           ///< approached from the first position
};

struct Play {
  std::string joint;    ///< the driven joint; "" if there is none
  bool slides = false;  ///< whether its coordinate is a position (m), not an angle (rad)
  std::vector<LooseComponent> components;
  std::vector<Tolerance> tolerances;  ///< that the quantiles contain
  std::vector<OutputQuantity> quantities;
  std::vector<PlayPosition> positions;
  std::vector<std::string> notes;           ///< what is not considered
  bool sampled = false;                     ///< whether ranges have quantiles
  bool loaded = false;                      ///< whether positions have loaded poses
  std::vector<std::string> reactions = {};  ///< joints whose reactions they have
  std::vector<PlayJump> jumps = {};
};

/// Throws ModelError for unknown names, undriven motions, dependent constraints, positions that the mechanism
/// cannot reach, and if no position has a range; Interrupted.
Play find_play(const Scene& scene, const PlayOptions& options);

/// play.csv: the coordinate, then for each quantity Q (OutputQuantity::column) Q.ideal, Q.least, Q.greatest, Q.bound_least,
/// Q.bound_greatest, Q.linear; with samples Q.p0.135, Q.p2.5, Q.p50, Q.p97.5, Q.p99.865 (%); with loads Q.loaded_up
/// and Q.loaded_down. Cells of refused positions are empty.
Table play_table(const Play& play);
/// play_parts.csv: the coordinate, then Q.JOINT, the part of each joint in Q.greatest − Q.least.
Table play_parts_table(const Play& play);
/// play_loads.csv: the coordinate, then the reaction of each joint on its second body, JOINT.fx_up, .fy_up, .m_up
/// and likewise down.
Table play_loads_table(const Play& play);
/// play.json, without provenance.
nlohmann::json to_json(const Play& play);
/// The widest range of each quantity in a sentence, with the joints' shares.
std::vector<std::string> verdicts(const Play& play);

}  // namespace freeplay
