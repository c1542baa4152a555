// Bifurcations between two motions of a branch: test functions, whose sign changes, and their location.
//
// With the multipliers λ (without that of a shift along the motion):
//
//     fold    τ_ξ                      the key turns back
//     flip    Π (1 + λ_i)
//     torus   Π_{i<j} (1 − λ_i λ_j)    and a complex pair there
//     crossing  det A                  of the system for the next motion, which is regular at a fold
//
// Source: Kuznetsov, Elements of Applied Bifurcation Theory, 3rd ed. (2004), section 10.2. A grazing impact
// is located in its approach speed v: state and key are smooth functions of v, whereas the derivative of the
// map grows as 1/v (Nordmark, J. Sound Vib. 145 (1991) 279). Lift-off is located in the least force λ of a
// lasting contact likewise: state and key are smooth functions of λ > 0, and no motion has λ < 0.
#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/branch_solver.hpp"
#include "values/branch.hpp"

namespace freeplay {

/// A bifurcation with its motion.
struct BranchEvent {
  BifurcationKind kind = BifurcationKind::fold;
  double distance = 0;  ///< arclength from the motion before
  BranchMotion motion;
  double residual = 0;    ///< of the test function
  std::string name = {};  ///< of an event of the request
};

/// A function of the motions of a branch whose zeros are located.
struct BranchTest {
  BifurcationKind kind = BifurcationKind::event;
  std::string name;
  std::function<double(const BranchMotion&)> value;
};

/// Value of the test function of a fold, flip or torus at a motion.
double bifurcation_test(BifurcationKind kind, const BranchSolver& solver, const BranchMotion& m);
/// Whether the pair of multipliers with a product nearest 1 is complex.
bool has_complex_pair(const BranchSolver& solver, const BranchMotion& m);

/// Bifurcations between a motion and the one at the arclength `distance`, and
/// zeros of further tests, in their order. Refines the steps of the solver.
std::vector<BranchEvent> events_between(BranchSolver& solver, const BranchMotion& base, double distance,
                                        BranchMotion& next, const std::vector<BranchTest>& further);

/// The direction of the other branch at a crossing, a tangent orthogonal to that of the motion.
Eigen::VectorXd crossing_direction(const BranchSolver& solver, const BranchMotion& m);
/// The motion at which the key has a value, between a motion and the one at the arclength `distance`.
std::optional<BranchEvent> reach_key(const BranchSolver& solver, const BranchMotion& base, double distance,
                                     const BranchMotion& next, double value);

/// Amplitudes of the first motion of doubled period or of a crossing branch, in units of the tangent.
inline constexpr double first_amplitudes[] = {1e-2, 3e-2, 1e-3};
/// The first motion of doubled period beside a flip, by a solver of motions of this period.
std::optional<BranchMotion> doubled_motion(const BranchSolver& solver, const BranchMotion& flip);

/// Greatest rate of a coordinate or gap rate of an onset during a motion, the unit of approach speeds.
double greatest_speed(const BranchMotion& m);

/// A quantity that is positive in all motions of a branch: the approach speed of an onset (m/s), or the least
/// normal force of a lasting contact (N). The branch ends where it comes to 0.
struct Positive {
  BifurcationKind kind = BifurcationKind::grazing;  ///< grazing or liftoff
  std::size_t index = 0;                            ///< of the onset, or in EndState::lasting
  double value = NAN;
  double share = NAN;  ///< of the greatest speed of the motion, or of the contact's greatest force
  bool same(const Positive& other) const { return kind == other.kind && index == other.index; }
};
/// All of a motion.
std::vector<Positive> positive_quantities(const BranchMotion& m);
/// That with the least share, if any; NaN share: none.
Positive least_positive(const BranchMotion& m);

/// Whether a quantity of the last motion is less than that of the motion before.
bool falling(const std::vector<BranchMotion>& motions, const Positive& last);
/// Derivative of the share of a quantity of a motion by arclength, from a motion before it.
double slope_of(const BranchSolver& solver, const BranchMotion& m, const BranchMotion& before,
                const Positive& quantity);

/// Name of its contact.
std::string contact_name(const BranchMotion& m, const Positive& p);
/// A motion of N periods as a result.
Orbit branch_orbit(int periods, const BranchMotion& m);

/// A motion whose positive quantity is 0.
struct Vanished {
  double parameter = 0, period = 0;
  double error = 0;  ///< estimated, of the parameter
  State state;       ///< of the section
};
/// Extrapolates motions with decreasing values of a quantity to 0. `motions`: the last ones of a branch with
/// the same sequence.
Vanished extrapolated(const std::vector<BranchMotion>& motions, const Positive& quantity);
/// The motion with this sequence of onsets beside one whose quantity vanishes, at a greater value of the key
/// if `side` is 1, at a smaller one if it is −1; `m`: the last motion before.
std::optional<BranchMotion> motion_beside(const BranchSolver& solver, const BranchMotion& m,
                                          const Vanished& g, double side, const std::vector<int>& sequence);

// The branch of motions with a new impact, where a motion begins to touch a contact.
//
// Near the motion that just touches, with the local coordinates u and the key ξ relative to it, an impact of
// approach speed v has v² = κ_u·u + κ_ξ ξ to first order, and the map is
//
//     P = A u + b ξ + c v
//
// (Nordmark, J. Sound Vib. 145 (1991) 279). Periodic motions with this impact are therefore, per unit of v,
//
//     (1 − A) u − b ξ = c,     κ_u·u + κ_ξ ξ = 0.
//
// A and b are those of the motion without the impact; κ and c follow from runs beside it.

/// A contact that a motion begins to touch.
struct NewContact {
  std::size_t onset = 0;  ///< index of its onset among those of the motions that touch it
  int contact = 0;
  double speed = 0;  ///< m/s, of approach, at the motion at which it was found
};
/// The contact that the branch touches within `distance` after a motion; nullopt if the order of onsets does
/// not change there by one slow onset.
std::optional<NewContact> new_contact_ahead(const BranchSolver& solver, const BranchMotion& m,
                                            double distance);

/// The first motion with this impact beside a motion that just touches, with the tangent away from it.
std::optional<BranchMotion> first_with_impact(const BranchSolver& solver, const BranchMotion& m,
                                              const NewContact& grazed, std::string& reason);

}  // namespace freeplay
