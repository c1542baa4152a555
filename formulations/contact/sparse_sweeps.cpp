#include "formulations/contact/sparse_sweeps.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

SolverSummary sparse_sweeps(SparseIsland& x, double accepted, std::vector<double>& rates, int most) {
  int done = 0;
  auto& u = rates;
  u.resize(x.slots.size());
  for (std::size_t r = 0; r < u.size(); ++r) u[r] = x.rate(static_cast<int>(r));
  const auto change = [&](int row, double by) {  // D is symmetric
    if (row < 0 || by == 0) return;
    x.impulse[row] += by;
    for (int e = x.begin[row]; e < x.begin[row + 1]; ++e) u[x.column[e]] += by * x.value[e];
  };
  for (int sweep = 0; sweep < most; ++sweep) {
    ++done;
    double moved = 0;
    for (auto& c : x.unknowns) {
      const int n = c.normal, t = c.tangent;
      const double Pn = n >= 0 ? x.impulse[n] : 0, Pt = t >= 0 ? x.impulse[t] : 0,
                   Dnn = n >= 0 ? x.entry(n, n) : 0, Dtt = t >= 0 ? x.entry(t, t) : 0,
                   Dnt = n >= 0 && t >= 0 ? x.entry(n, t) : 0;
      const double bn = n >= 0 ? u[n] - Dnn * Pn - Dnt * Pt : 0, bt = t >= 0 ? u[t] - Dtt * Pt - Dnt * Pn : 0;
      if (!solve_one(c, bn, bt, Dnn, Dnt, Dtt)) return {false, done};
      change(n, c.impulse_n - Pn);
      change(t, c.impulse_t - Pt);
      moved = std::max({moved, Dnn * std::abs(c.impulse_n - Pn), Dtt * std::abs(c.impulse_t - Pt)});
    }
    if (moved <= 0.1 * accepted && x.residual() <= accepted) return {true, done};
  }
  return {false, done};
}

}  // namespace freeplay
