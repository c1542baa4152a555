// Bifurcations between two motions of a branch: test functions, whose sign changes, and their location.
//
// With the multipliers λ (without that of a shift along the motion):
//
//     fold    τ_ξ                      the key turns back
//     flip    Π (1 + λ_i)
//     torus   Π_{i<j} (1 − λ_i λ_j)    and a complex pair there
//
// Source: Kuznetsov, Elements of Applied Bifurcation Theory, 3rd ed. (2004), section 10.2. A grazing impact is
// located in its approach speed v: state and key are smooth functions of v, whereas the derivative of the map
// grows as 1/v (Nordmark, J. Sound Vib. 145 (1991) 279).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "facade/branch_solver.hpp"
#include "values/branch.hpp"

namespace freeplay {

/// A bifurcation with its motion.
struct BranchEvent {
  BifurcationKind kind = BifurcationKind::fold;
  double distance = 0;  ///< arclength from the motion before
  BranchMotion motion;
  double residual = 0;  ///< of the test function
};

/// Bifurcations between a motion and the one at the arclength `distance`, in their order. Refines the steps of
/// the solver.
std::vector<BranchEvent> events_between(BranchSolver& solver, const BranchMotion& base, double distance,
                                        BranchMotion& next);

/// The motion at which the key has a value, between a motion and the one at the arclength `distance`.
std::optional<BranchEvent> reach_key(const BranchSolver& solver, const BranchMotion& base, double distance,
                                     const BranchMotion& next, double value);

/// The tangent of the branch of doubled period at a flip, in coordinates of the motion.
Eigen::VectorXd doubling_direction(const BranchMotion& flip);

/// An impact whose approach speed decreases to 0 along a branch.
struct Grazing {
  std::size_t onset = 0;  ///< index of the onset
  double parameter = 0, period = 0;
  double error = 0;  ///< estimated, of the parameter
  State state;       ///< of the section
};
/// Extrapolates motions of decreasing approach speed of one onset to speed 0. `motions`: the last ones of a
/// branch with the same sequence.
Grazing grazing_of(const std::vector<BranchMotion>& motions, std::size_t onset);
/// The onset with the least approach speed relative to the fastest one, if any; NaN speed: none.
struct SlowOnset {
  std::size_t onset = 0;
  double speed = NAN, share = NAN;
};
SlowOnset slowest_onset(const BranchMotion& m);

}  // namespace freeplay
