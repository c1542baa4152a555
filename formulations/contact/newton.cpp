#include "formulations/contact/newton.hpp"

#include <Eigen/LU>
#include <Eigen/QR>

#include <cmath>
#include <type_traits>

#include "formulations/contact/solvers.hpp"

namespace freeplay {

/// Newton's method on the projections (newton.hpp). The step is halved while it does not
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

/// Computes the pattern of the Jacobian: that of D, with the diagonal and both rows of a contact.
void SparseNewton::analyse(const SparseIsland& x) {
  begin_.assign(1, 0);
  column_.clear();
  const auto add_row = [&](int r, int other) {
    const int own = x.begin[r], end = x.begin[r + 1], first = static_cast<int>(column_.size());
    column_.insert(column_.end(), x.column.begin() + own, x.column.begin() + end);
    for (const int s : {r, other})
      if (s >= 0 && std::find(column_.begin() + first, column_.end(), s) == column_.end())
        column_.push_back(s);
    begin_.push_back(static_cast<int>(column_.size()));
  };
  normal_of_.assign(x.slots.size(), -1);
  for (const auto& c : x.unknowns)
    if (c.tangent >= 0) normal_of_[c.tangent] = c.normal;
  for (std::size_t r = 0; r < x.slots.size(); ++r) add_row(static_cast<int>(r), normal_of_[r]);
  pattern_begin_ = begin_;
  pattern_column_ = column_;
  jacobian_.analyse(pattern_begin_, pattern_column_);
}

double& SparseNewton::at(int row, int column) {
  int e = begin_[row];
  while (column_[e] != column) ++e;
  return jacobian_.values()[e];
}

/// Computes F of the projections at the present impulses and, if requested, its derivative; returns
/// |F|².
double SparseNewton::project(const SparseIsland& x, bool with_derivative, double proximal) {
  struct Rows {
    const SparseIsland& x;
    SparseNewton& in;
    double proximal, sum = 0;
    double rate(int r) const { return x.rate(r); }
    double impulse(int r) const { return x.impulse[r]; }
    double rho(int r) const {
      const double d = x.entry(r, r);
      return d > 0 ? 1 / d : 0;
    }
    void value(int r, double f) {
      in.F_[r] = f;
      sum += f * f;
    }
    void follows(int r, double rho) {
      in.follow(x, r, rho);
      in.at(r, r) += proximal;
    }
    void free(int r) { in.at(r, r) = 1; }
    void slides(int r, int n, double c) {
      free(r);
      in.at(r, n) = c;
    }
  } rows{x, *this, proximal};
  if (with_derivative) std::ranges::fill(jacobian_.values(), 0.0);
  project_on_laws(x.unknowns, rows, with_derivative);
  return rows.sum;
}

/// Sets row r of the Jacobian to ρ times the row of D.
void SparseNewton::follow(const SparseIsland& x, int r, double rho) {
  for (int e = x.begin[r]; e < x.begin[r + 1]; ++e)
    jacobian_.values()[begin_[r] + e - x.begin[r]] = rho * x.value[e];
}

SolverSummary SparseNewton::solve(SparseIsland& x, double accepted, int most) {
  int steps = 0;
  const int rows = static_cast<int>(x.slots.size());
  analyse(x);
  F_.resize(x.slots.size());
  step_.resize(x.slots.size());
  for (int i = 0; i < most; ++i) {
    ++steps;
    double before = 0;
    // for shared contact forces: the least change
    for (const double proximal : {0.0, 1e-9, 1e-6}) {
      before = project(x, true, proximal);
      if (!std::isfinite(before)) return {false, steps};
      if (proximal == 0 && x.residual() <= std::max(accepted, x.attainable())) return {true, steps};
      if (jacobian_.factor(1e-11)) break;
    }
    for (int r = 0; r < rows; ++r) step_[r] = -F_[r];
    jacobian_.solve(step_.data());
    P_ = x.impulse;
    double share = 1;
    for (int k = 0; k < 12; ++k, share *= 0.5) {
      for (int r = 0; r < rows; ++r) x.impulse[r] = P_[r] + share * step_[r];
      if (project(x, false, 0) < before) break;
    }
  }
  return {x.residual() <= std::max(accepted, x.attainable()), steps};
}

bool SparseNewton::hold(SparseIsland& x) {
  const int rows = static_cast<int>(x.slots.size());
  analyse(x);
  for (const double proximal : {0.0, 1e-9, 1e-6}) {
    x.impulse.resize(x.slots.size());
    std::ranges::fill(jacobian_.values(), 0.0);
    for (int r = 0; r < rows; ++r) {
      const double d = x.entry(r, r), rho = d > 0 ? 1 / d : 0;
      follow(x, r, rho);
      at(r, r) += d > 0 ? proximal : 1;
      x.impulse[r] = -rho * x.b[r];
    }
    if (!jacobian_.factor(1e-11)) continue;
    jacobian_.solve(x.impulse.data());
    return std::ranges::all_of(x.impulse, [](double impulse) { return std::isfinite(impulse); });
  }
  return false;
}

}  // namespace freeplay
