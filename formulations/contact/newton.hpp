// Newton's method for contact problems. One loop, newton_steps(), serves three forms of the equations:
// a dense D (newton.cpp), D by rows (SparseNewton, for long islands), and velocities of bodies without
// joints (free_sweeps.hpp).
//
// The first two solve the contact and friction laws written as projections,
//
//     F_N = P_N − (P_N − ρ_N (u_N − target_N))⁺,
//     F_T = P_T − clamp(P_T − ρ_T (u_T − target_T), ±(bound + μ P_N)),
//
// with ρ = 1/D_rr (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353).
// project_on_laws() computes F and the structure of each row of its derivative, for any storage of
// D.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "formulations/contact/contact_equations.hpp"
#include "formulations/contact/island_groups.hpp"
#include "formulations/contact/solvers.hpp"
#include "numerics/sparse_lu.hpp"

namespace freeplay {

/// Newton's method on F = 0 from the present iterate. A step is halved up to `halvings` times while it
/// does not decrease |F|. `equations` provides
///
///     evaluate(with_derivative): F at the present iterate and, if requested, F'; returns a norm of F,
///     solved(): whether the present iterate is accepted,
///     find_step(): the step −F'⁻¹ F; false if there is none,
///     move(share): the iterate of the last find_step() plus this share of the step.
template <class Equations>
SolverSummary newton_steps(Equations& equations, int most, int halvings) {
  for (int i = 0; i < most; ++i) {
    const double before = equations.evaluate(true);
    if (equations.solved()) return {true, i + 1};
    if (!std::isfinite(before) || !equations.find_step()) return {false, i + 1};
    double share = 1;
    for (int k = 0; k < halvings; ++k, share *= 0.5) {
      equations.move(share);
      if (equations.evaluate(false) < before) break;
    }
  }
  return {false, most};
}

/// `row` provides for each row, with the present impulses,
///
///     rate(r), impulse(r),   rho(r): 1/D_rr, 0 where the row cannot move,
///
/// and receives value(r, F_r) and, if `with_derivative`, one of
///
///     follows(r, ρ): the row of F' is ρ times the row of D,
///     free(r): the row of F' is that of P_r,
///     free(r) and then entry(r, n) = c: it is that of P_r plus c times that of P_n, in sliding.
template <class Row>
void project_on_laws(const std::vector<ContactUnknown>& unknowns, Row& row, bool with_derivative) {
  const auto trial_of = [&](int r, double target) {
    const double rho = row.rho(r);
    return rho != 0 ? row.impulse(r) - rho * (row.rate(r) - target) : 0;
  };
  for (const auto& c : unknowns) {
    double pressed = 0;
    if (c.normal >= 0) {
      pressed = row.impulse(c.normal);
      const double trial = trial_of(c.normal, c.target_n);
      row.value(c.normal, pressed - (trial > 0 ? trial : 0));
      if (with_derivative) {
        if (trial > 0)
          row.follows(c.normal, row.rho(c.normal));
        else
          row.free(c.normal);
      }
    }
    if (c.tangent < 0) continue;
    const double bound = c.bound + c.friction * std::max(0.0, pressed);
    const double trial = trial_of(c.tangent, c.target_t), kept = std::clamp(trial, -bound, bound);
    row.value(c.tangent, row.impulse(c.tangent) - kept);
    if (!with_derivative) continue;
    if (kept == trial && row.rho(c.tangent) != 0) {
      row.follows(c.tangent, row.rho(c.tangent));
      continue;
    }
    row.free(c.tangent);
    if (c.normal >= 0 && pressed > 0) row.entry(c.tangent, c.normal) = trial > 0 ? -c.friction : c.friction;
  }
}

/// SparseNewton: Newton's method on the projections for an island of many contacts, started from
/// the given impulses, with sparse factors of the Jacobian. It owns the factors and its work vectors.
class SparseNewton {
 public:
  /// What follows where contacts share their loads, so that the Jacobian is singular.
  enum class Shared { least_change, fail };
  /// Solves for the impulses.
  SolverSummary solve(SparseIsland& x, double accepted, int most, Shared shared = Shared::least_change);
  /// Computes the impulses, of either sign, for which the rate of every row vanishes; where rows
  /// depend on each other, the least impulses. Returns false if there are none.
  bool hold(SparseIsland& x);

 private:
  class Projections;
  void analyse(const SparseIsland& x);
  double& at(int row, int column);
  void follow(const SparseIsland& x, int r, double rho);
  bool factor(Shared shared);

  // rows of the Jacobian: those of D, then entries that D lacks
  std::vector<int> begin_, column_, pattern_begin_, pattern_column_;
  std::vector<int> normal_of_;  // the normal row of each tangential row
  SparseLu jacobian_;
  std::vector<double> F_, P_, step_;
};

}  // namespace freeplay
