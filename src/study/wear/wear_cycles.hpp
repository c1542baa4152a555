// Wear over many turns, in cycles: the loads of some turns are computed with the present surfaces, and wear is
// extrapolated by a number of turns N that changes neither the clearance nor the rates of wear by more than a
// stated share. A cycle is a step of Heun's method in the number of turns,
//
//     h*      = h_k + N r(h_k; S_k)               predictor, S_k: the loads known so far
//     S_(k+1) = loads of runs with the surfaces h*
//     h_(k+1) = h_k + N/2 [r(·; S_k) + r(·; S_(k+1))]
//
// where r is the implicit wear of worn_bearing.hpp, so each cycle needs one set of runs. S_(k+1) is used by the
// next cycle, too. The method is of second order in N.
//
// Choice of N. Let q be the greatest relative change, over the joints, of the mean work ∫F ds of a turn from S_k
// to S_(k+1), and of the greatest depth of a cycle from h* to h_(k+1), twice. What the statistical errors
// explain (two standard errors) is subtracted. A cycle is repeated with fewer turns if q > 2 share, and the next N
// is 0.9 share/q times the last one, by a factor of at least 0.2 and at most 4. N is not less than the number of
// simulated turns for this reason, since it costs nothing to use them. If 20 cycles in a row would have to be
// shorter, wear cannot be extrapolated, and the cycles end. The greatest depth grows by at most
// share × the present clearance in a cycle.
//
// Errors. The mean work of a turn has a standard error over turns and starts: the greater one of s/√n over all
// turns and over the means of the starts. The greatest depth has one of its own, since it also depends on the
// directions of the loads: half of the difference between even and odd starts, as a mean square over all cycles;
// it counts if it is greater. S_k acts in the cycles k − 1 and k, with half of the depth of each, so
//
//     σ² = Σ ε_k² ((Δh_(k−1) + Δh_k)/2)².
//
// The extrapolation error is the sum of |h_(k+1) − h*| of the greatest depth less what the statistical error
// explains: the error of the first-order method, which bounds that of Heun's method in a smooth change.
#pragma once

#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

#include "study/wear/worn_bearing.hpp"

namespace freeplay {

/// Loads of one joint in some turns, from all starts.
struct TurnLoads {
  /// Classes of a degree in both bodies, or wider ones if there are more than 400.
  std::vector<BearingLoad> loads;
  double turns = 0;  ///< over which they are sums
  double work = 0;   ///< N m, mean of ∫F ds of a turn
  double error = 0;  ///< N m, its standard error; 0 if one start counts no turns
  /// Loads and turns of the starts with even and odd numbers; empty for one start.
  std::vector<BearingLoad> even, odd;
  double even_turns = 0, odd_turns = 0;
};

/// The loads of all starts of one joint. `turns`: of each start.
TurnLoads united(const std::vector<BearingLoads>& starts, double turns);

/// Where wear ends, and how the cycles are chosen.
struct WearLimits {
  static constexpr double none = std::numeric_limits<double>::infinity();
  double turns = none;      ///< total number of turns
  double depth = none;      ///< m, greatest depth of one surface
  double clearance = none;  ///< m, measured clearance (WornBearing::measured_clearance) of a joint
  double share = 0.05;      ///< greatest relative change in a cycle
  double longest = none;    ///< turns of a cycle
};

/// Greatest depth of one surface with its errors.
struct WornDepth {
  double depth = 0;          ///< m
  double statistical = 0;    ///< m, standard error
  double extrapolation = 0;  ///< m
};

/// A joint after a cycle.
struct WornJoint {
  WornBearing bearing;  ///< its surfaces
  WornDepth in_bearing, in_journal;
  double work = 0, error = 0;  ///< N m, of the turns at the end of the cycle, as in TurnLoads
};

/// All joints after a cycle.
struct WearCycle {
  int number = 0;     ///< 0: before the first one
  double turns = 0;   ///< since the beginning
  double length = 0;  ///< turns of this cycle
  std::vector<WornJoint> joints;
};

/// Why the cycles ended; failed: runs with the worn surfaces, or their wear, cannot be computed.
enum class WearEnd { turns, depth, clearance, no_load, failed };

/// The cycles cannot go on.
struct WearStopped : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Makes the runs with these surfaces and returns the loads of each joint. `set`: counts the sets of runs from 0.
using LoadsOf = std::function<std::vector<TurnLoads>(const std::vector<WornBearing>& surfaces, int set)>;

/// Wears the joints until a limit is reached, and calls `done` after each cycle, first before any wear.
/// `simulated`: turns of each run. `at_work` is called often while wear is computed. Throws NoEquilibrium,
/// WearStopped, and what the functions throw.
WearEnd wear_cycles(std::vector<WornBearing> joints, const WearLimits& limits, double simulated,
                    const LoadsOf& loads_of, const std::function<void(const WearCycle&)>& done,
                    const std::function<void()>& at_work = {});

}  // namespace freeplay
