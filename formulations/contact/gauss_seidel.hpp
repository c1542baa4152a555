// Gauss–Seidel over contacts, from the given impulses: each contact is solved exactly with the
// impulses of all others fixed (Jourdan, Alart and Jean, Comput. Methods Appl. Mech. Eng. 155
// (1998) 31), for any storage of D.
#pragma once

#include <algorithm>
#include <cmath>

#include "formulations/contact/solvers.hpp"

namespace freeplay {

/// `p` has the impulses in its `unknowns` and provides entry(row, column) of D, rate(row) and residual()
/// with the present impulses; act(row, by, rates) adds what a change of an impulse changes. `rates`: work
/// space with an entry for each row.
template <class Problem>
SolverSummary sweep_contacts(Problem& p, double accepted, Eigen::VectorXd& rates, int most) {
  for (const auto& c : p.unknowns)
    for (const int row : {c.normal, c.tangent})
      if (row >= 0) rates[row] = p.rate(row);
  for (int sweep = 1; sweep <= most; ++sweep) {
    double moved = 0;
    for (auto& c : p.unknowns) {
      const int n = c.normal, t = c.tangent;
      const double Pn = c.impulse_n, Pt = c.impulse_t;
      const double Dnn = n >= 0 ? p.entry(n, n) : 0, Dtt = t >= 0 ? p.entry(t, t) : 0,
                   Dnt = n >= 0 && t >= 0 ? p.entry(n, t) : 0;
      const double bn = n >= 0 ? rates[n] - Dnn * Pn - Dnt * Pt : 0;
      const double bt = t >= 0 ? rates[t] - Dtt * Pt - Dnt * Pn : 0;
      if (!solve_one(c, bn, bt, Dnn, Dnt, Dtt)) return {false, sweep};
      if (n >= 0 && c.impulse_n != Pn) p.act(n, c.impulse_n - Pn, rates);
      if (t >= 0 && c.impulse_t != Pt) p.act(t, c.impulse_t - Pt, rates);
      moved = std::max({moved, Dnn * std::abs(c.impulse_n - Pn), Dtt * std::abs(c.impulse_t - Pt)});
    }
    if (moved <= 0.1 * accepted && p.residual() <= accepted) return {true, sweep};
  }
  return {false, most};
}

}  // namespace freeplay
