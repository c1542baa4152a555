#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "formulations/contact/projections.hpp"
#include "formulations/contact/solvers.hpp"

namespace freeplay {

/// Newton's method on the projections (projections.hpp). The step is halved while it does not
/// decrease |F|.
SolverSummary newton_from(From from, ContactEquations& p, double accepted) {
  auto& unknowns = p.unknowns;
  const int rows = p.rows;
  int steps = 0;
  const int most = from == From::nothing ? 100 : from == From::given ? 20 : 4;
  // up to this many rows, matrices are on the stack: steps of a small mechanism allocate no memory
  constexpr int few = 24;
  const auto within = [&]<int room>(std::integral_constant<int, room>) {
    using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, room, 1>;
    using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, room, room>;
    Vector F(rows), P(rows), now(rows), step(rows);
    Matrix J(rows, rows);
    const auto gather = [&](Vector& x) {
      for (const auto& c : unknowns) {
        if (c.normal >= 0) x[c.normal] = c.impulse_n;
        if (c.tangent >= 0) x[c.tangent] = c.impulse_t;
      }
    };
    const auto scatter = [&](const Vector& x) {
      for (auto& c : unknowns) {
        if (c.normal >= 0) c.impulse_n = x[c.normal];
        if (c.tangent >= 0) c.impulse_t = x[c.tangent];
      }
    };
    struct Rows {
      ContactEquations& p;
      Vector &F, &P;
      Matrix& J;
      double rate(int r) const { return p.rate(r); }
      double impulse(int r) const { return P[r]; }
      double rho(int r) const { return 1 / p.D(r, r); }
      void value(int r, double f) { F[r] = f; }
      void follows(int r, double rho) { J.row(r) = rho * p.D.row(r).head(p.rows); }
      void free(int r) {
        J.row(r).setZero();
        J(r, r) = 1;
      }
      void slides(int r, int n, double c) {
        free(r);
        J(r, n) = c;
      }
    } projected{p, F, now, J};
    const auto evaluate = [&](bool with_derivative) {
      gather(now);
      project_on_laws(unknowns, projected, with_derivative);
      return F.squaredNorm();
    };
    if (from == From::nothing)
      for (auto& c : unknowns) c.impulse_n = c.impulse_t = 0;
    for (int i = 0; i < most; ++i) {
      ++steps;
      const double before = evaluate(true);
      if (p.residual() <= accepted) return true;
      if (!std::isfinite(before)) return false;
      P = now;
      const Eigen::PartialPivLU<Matrix> lu(J);
      const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
      if (pivots.minCoeff() > 1e-12 * pivots.maxCoeff()) {
        step = -lu.solve(F);
      } else if (from == From::last) {
        return false;
      } else {  // forces are not unique: take the least change
        Eigen::CompleteOrthogonalDecomposition<Matrix> decomposition;
        decomposition.setThreshold(1e-11);
        step = -decomposition.compute(J).solve(F);
      }
      double s = 1;
      for (int k = 0; k < 12; ++k, s *= 0.5) {
        scatter(P + s * step);
        if (evaluate(false) < before) break;
      }
    }
    return false;
  };
  const bool solved = rows <= few ? within(std::integral_constant<int, few>())
                                  : within(std::integral_constant<int, Eigen::Dynamic>());
  return {solved, steps};
}

SolverSummary newton(ContactEquations& p, double accepted, SolverRoom&) {
  return newton_from(From::nothing, p, accepted);
}

SolverSummary newton_from_last(ContactEquations& p, double accepted, SolverRoom& room) {
  auto& unknowns = p.unknowns;
  if (std::ranges::none_of(unknowns, [](const auto& c) { return c.impulse_n > 0 || c.impulse_t != 0; }))
    return {};
  auto& last = room.last;
  last.clear();
  for (const auto& c : unknowns) last.push_back({c.impulse_n, c.impulse_t});
  const auto result = newton_from(From::last, p, accepted);
  for (std::size_t i = 0; !result.solved && i < last.size(); ++i) {
    unknowns[i].impulse_n = last[i][0];
    unknowns[i].impulse_t = last[i][1];
  }
  return result;
}

}  // namespace freeplay
