// Newton's method on contact and friction laws written as projections, and for long islands BandNewton,
//
//     F_N = P_N − (P_N − ρ_N (u_N − target_N))⁺,
//     F_T = P_T − clamp(P_T − ρ_T (u_T − target_T), ±(bound + μ P_N)),
//
// with ρ = 1/D_rr (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353).
// project_on_laws() computes F and the structure of each row of its derivative, for any storage of
// D.
#pragma once

#include <algorithm>
#include <vector>

#include "formulations/contact/contact_equations.hpp"
#include "formulations/contact/island_groups.hpp"
#include "numerics/band_lu.hpp"

namespace freeplay {

/// `row` provides for each row, with the present impulses,
///
///     rate(r), impulse(r),   rho(r): 1/D_rr, 0 where the row cannot move,
///
/// and receives value(r, F_r) and, if `with_derivative`, one of
///
///     follows(r, ρ): the row of F' is ρ times the row of D,
///     free(r): the row of F' is that of P_r,
///     slides(r, n, c): the row of F' is that of P_r plus c times that of P_n.
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
    if (kept == trial && row.rho(c.tangent) != 0)
      row.follows(c.tangent, row.rho(c.tangent));
    else if (c.normal >= 0 && pressed > 0)
      row.slides(c.tangent, c.normal, trial > 0 ? -c.friction : c.friction);
    else
      row.free(c.tangent);
  }
}

/// BandNewton: Newton's method on the projections for an island of many contacts,
/// started from the given impulses. The Jacobian is factorised as a band matrix, in the order of a
/// breadth-first walk over the island (Cuthill and McKee, Proc. 24th ACM Conf. (1969) 157), so that
/// the cost along a chain of bodies is linear. It owns the band matrix and its work vectors.
class BandNewton {
 public:
  /// Computes place_ of each row in the order of a walk that starts at the last unknown of a first
  /// walk. Returns the half-bandwidth in rows.
  int order(const SparseIsland& x);
  /// Solves for the impulses. Returns without a solution if the band is too wide.
  SolverSummary solve(SparseIsland& x, double accepted, int most);
  /// Computes the impulses, of either sign, for which the rate of every row vanishes; where rows
  /// depend on each other, the least impulses. Returns false if the band is too wide.
  bool hold(SparseIsland& x);

 private:
  double project(const SparseIsland& x, bool with_derivative, double proximal);

  std::vector<int> unknown_;       // unknown of each row
  std::vector<int> place_, walk_;  // order of rows in the band
  BandLu band_;
  std::vector<double> F_, P_, step_;
};

}  // namespace freeplay
