// Gauss–Seidel over contacts, from the given impulses: each contact is solved exactly with the
// impulses of all others fixed (Jourdan, Alart and Jean, Comput. Methods Appl. Mech. Eng. 155
// (1998) 31), for any storage of D.
#pragma once

#include <algorithm>
#include <cmath>

#include "formulations/contact/island_groups.hpp"
#include "formulations/contact/solvers.hpp"

namespace freeplay {

/// `p` has `unknowns` and provides entry(row, column) of D, impulse(row, the unknown's value),
/// rate(row) with the present impulses, and residual(); change(row, by) changes an impulse and the
/// rates that depend on it.
template <class Problem>
SolverSummary sweep_contacts(Problem& p, double accepted, int most) {
  for (int sweep = 1; sweep <= most; ++sweep) {
    double moved = 0;
    for (auto& c : p.unknowns) {
      const int n = c.normal, t = c.tangent;
      const double Pn = n >= 0 ? p.impulse(n, c.impulse_n) : c.impulse_n,
                   Pt = t >= 0 ? p.impulse(t, c.impulse_t) : c.impulse_t;
      const double Dnn = n >= 0 ? p.entry(n, n) : 0, Dtt = t >= 0 ? p.entry(t, t) : 0,
                   Dnt = n >= 0 && t >= 0 ? p.entry(n, t) : 0;
      const double bn = n >= 0 ? p.rate(n) - Dnn * Pn - Dnt * Pt : 0;
      const double bt = t >= 0 ? p.rate(t) - Dtt * Pt - Dnt * Pn : 0;
      if (!solve_one(c, bn, bt, Dnn, Dnt, Dtt)) return {false, sweep};
      if (n >= 0 && c.impulse_n != Pn) p.change(n, c.impulse_n - Pn);
      if (t >= 0 && c.impulse_t != Pt) p.change(t, c.impulse_t - Pt);
      moved = std::max({moved, Dnn * std::abs(c.impulse_n - Pn), Dtt * std::abs(c.impulse_t - Pt)});
    }
    if (moved <= 0.1 * accepted && p.residual() <= accepted) return {true, sweep};
  }
  return {false, most};
}

// Gauss–Seidel over the contacts of an island with D by rows (island_groups.hpp), from the given
// impulses.

/// `rates`: work space for the rates of the rows.
SolverSummary sparse_sweeps(SparseIsland& x, double accepted, std::vector<double>& rates, int most);

}  // namespace freeplay
