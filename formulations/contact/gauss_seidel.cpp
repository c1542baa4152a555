#include <algorithm>
#include <cmath>

#include "formulations/contact/solvers.hpp"

namespace freeplay {

/// Contact by contact, each solved exactly with the others held, from the impulses given (Jourdan, Alart,
/// Jean, Comput. Methods Appl. Mech. Eng. 155 (1998) 31).
SolverSummary sweeps(ContactEquations& p, double accepted, SolverRoom& room, int most) {
  const auto& D = p.D;
  const int rows = p.rows;
  auto& u = room.rates;
  int done = 0;
  u.conservativeResize(std::max<Eigen::Index>(u.size(), rows));
  for (const auto& c : p.unknowns)
    for (const int row : {c.normal, c.tangent})
      if (row >= 0) u[row] = p.rate(row);
  const auto change = [&](int column, double by) {
    if (column >= 0 && by != 0) u.head(rows) += by * D.col(column).head(rows);
  };
  for (int sweep = 0; sweep < most; ++sweep) {
    ++done;
    double moved = 0;
    for (auto& c : p.unknowns) {
      const int n = c.normal, t = c.tangent;
      const double Pn = c.impulse_n, Pt = c.impulse_t, Dnn = n >= 0 ? D(n, n) : 0, Dtt = t >= 0 ? D(t, t) : 0,
                   Dnt = n >= 0 && t >= 0 ? D(n, t) : 0;
      const double bn = n >= 0 ? u[n] - Dnn * Pn - Dnt * Pt : 0;
      const double bt = t >= 0 ? u[t] - Dtt * Pt - Dnt * Pn : 0;
      if (!solve_one(c, bn, bt, Dnn, Dnt, Dtt)) return {false, done};
      change(n, c.impulse_n - Pn);
      change(t, c.impulse_t - Pt);
      moved = std::max({moved, Dnn * std::abs(c.impulse_n - Pn), Dtt * std::abs(c.impulse_t - Pt)});
    }
    if (moved <= 0.1 * accepted && p.residual() <= accepted) return {true, done};
  }
  return {false, done};
}

SolverSummary gauss_seidel(ContactEquations& p, double accepted, SolverRoom& room) {
  return sweeps(p, accepted, room, 2000);
}

/// Where the same contacts press, stick and slide as in the last problem a step or two of Newton's are exact. Many contacts
/// that share their loads converge slowly in sweeps: from near the solution Newton's steps are few.
SolverSummary mixed_gauss_seidel(ContactEquations& p, double accepted, SolverRoom& room) {
  auto sum = newton_from_last(p, accepted, room);
  const auto add = [&](const SolverSummary& one) {
    sum.solved = one.solved;
    sum.iterations += one.iterations;
  };
  if (!sum.solved) add(sweeps(p, accepted, room, 100));
  if (!sum.solved) add(newton_from(From::given, p, accepted));
  if (!sum.solved) add(sweeps(p, accepted, room, 2000));
  return sum;
}

}  // namespace freeplay
