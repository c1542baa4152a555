#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/contact/solvers.hpp"

namespace freeplay {

/// Proximal-point iteration: each iterate solves the problem with D + ε and b − εP of the last
/// iterate. Lemke's method solves these problems where contacts share their loads and D is
/// singular. Newton steps on the original problem follow each iterate.
SolverSummary proximal(ContactEquations& p, double accepted, SolverRoom& room) {
  auto& unknowns = p.unknowns;
  auto& D = p.D;
  auto& b = p.b;
  const int rows = p.rows;
  int pivots = 0;
  constexpr int most = 30;
  const Eigen::MatrixXd kept = D.topLeftCorner(rows, rows);
  const Eigen::VectorXd base = b.head(rows);
  Eigen::VectorXd last = Eigen::VectorXd::Zero(rows), weight(rows);
  const double greatest = kept.diagonal().cwiseAbs().maxCoeff();
  for (int r = 0; r < rows; ++r) weight[r] = std::max(kept(r, r), 1e-3 * greatest);
  for (const double epsilon : {1e-4, 1e-2, 1.0})
    for (int i = 0; i < most; ++i) {
      D.topLeftCorner(rows, rows).diagonal() += epsilon * weight;
      b.head(rows) -= epsilon * weight.cwiseProduct(last);
      const auto found = lemke(p, accepted, room);
      pivots += found.iterations;
      D.topLeftCorner(rows, rows) = kept;
      b.head(rows) = base;
      if (!found.solved) break;
      double moved = 0;
      for (const auto& c : unknowns) {
        if (c.normal >= 0)
          moved = std::max(
              moved, weight[c.normal] * std::abs(c.impulse_n - std::exchange(last[c.normal], c.impulse_n)));
        if (c.tangent >= 0)
          moved = std::max(
              moved, weight[c.tangent] * std::abs(c.impulse_t - std::exchange(last[c.tangent], c.impulse_t)));
      }
      const auto refined = newton_from(From::given, p, accepted);
      pivots += refined.iterations;
      if (refined.solved) return {true, pivots};
      for (auto& c : unknowns) {
        if (c.normal >= 0) c.impulse_n = last[c.normal];
        if (c.tangent >= 0) c.impulse_t = last[c.tangent];
      }
      if (p.residual() <= std::max(accepted, p.attainable())) return {true, pivots};
      if (epsilon * moved <= 1e-3 * accepted) break;
    }
  return {false, pivots};
}

}  // namespace freeplay
