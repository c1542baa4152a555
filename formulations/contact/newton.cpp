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

namespace {

/// Number of operations of one factorisation above which sweeps are cheaper.
constexpr double most_operations = 3e7;

}  // namespace

int BandNewton::order(const SparseIsland& x) {
  const int rows = static_cast<int>(x.slots.size()), count = static_cast<int>(x.unknowns.size());
  unknown_.assign(rows, 0);
  for (int i = 0; i < count; ++i)
    for (const int row : {x.unknowns[i].normal, x.unknowns[i].tangent})
      if (row >= 0) unknown_[row] = i;
  place_.resize(std::max(count, rows));
  int start = 0;
  for (int walk = 0; walk < 2; ++walk) {
    std::fill_n(place_.begin(), count, 0);
    walk_.assign(1, start);
    place_[start] = 1;
    for (std::size_t k = 0; k < walk_.size(); ++k) {
      const auto& u = x.unknowns[walk_[k]];
      for (const int row : {u.normal, u.tangent})
        for (int e = row >= 0 ? x.begin[row] : 0; row >= 0 && e < x.begin[row + 1]; ++e)
          if (int& mark = place_[unknown_[x.column[e]]]; mark == 0) {
            mark = 1;
            walk_.push_back(unknown_[x.column[e]]);
          }
    }
    start = walk_.back();
  }
  int at = 0;
  for (const int i : walk_)
    for (const int row : {x.unknowns[i].normal, x.unknowns[i].tangent})
      if (row >= 0) place_[row] = at++;
  int width = 0;
  for (int r = 0; r < rows; ++r)
    for (int e = x.begin[r]; e < x.begin[r + 1]; ++e)
      width = std::max(width, std::abs(place_[r] - place_[x.column[e]]));
  return at == rows ? width : rows;
}

/// Computes F of the projections at the present impulses and, if requested, its derivative in the
/// band; returns |F|².
double BandNewton::project(const SparseIsland& x, bool with_derivative, double proximal) {
  struct Rows {
    const SparseIsland& x;
    BandNewton& in;
    double proximal, sum = 0;
    double rate(int r) const { return x.rate(r); }
    double impulse(int r) const { return x.impulse[r]; }
    double rho(int r) const {
      const double d = x.entry(r, r);
      return d > 0 ? 1 / d : 0;
    }
    double& at(int r, int s) { return in.band_.at(in.place_[r], in.place_[s]); }
    void value(int r, double f) {
      in.F_[r] = f;
      sum += f * f;
    }
    void follows(int r, double rho) {
      for (int e = x.begin[r]; e < x.begin[r + 1]; ++e) at(r, x.column[e]) = rho * x.value[e];
      at(r, r) += proximal;
    }
    void free(int r) { at(r, r) = 1; }
    void slides(int r, int n, double c) {
      free(r);
      at(r, n) = c;
    }
  } rows{x, *this, proximal};
  project_on_laws(x.unknowns, rows, with_derivative);
  return rows.sum;
}

SolverSummary BandNewton::solve(SparseIsland& x, double accepted, int most) {
  int steps = 0;
  const int rows = static_cast<int>(x.slots.size()), width = order(x);
  if (static_cast<double>(rows) * width * width > most_operations) return {};
  F_.resize(x.slots.size());
  step_.resize(x.slots.size());
  for (int i = 0; i < most; ++i) {
    ++steps;
    double before = 0;
    // for shared contact forces: the least change
    for (const double proximal : {0.0, 1e-9, 1e-6}) {
      band_.begin(rows, width);
      before = project(x, true, proximal);
      if (!std::isfinite(before)) return {false, steps};
      if (proximal == 0 && x.residual() <= std::max(accepted, x.attainable())) return {true, steps};
      if (band_.factor(1e-11)) break;
    }
    for (int r = 0; r < rows; ++r) step_[place_[r]] = -F_[r];
    band_.solve(step_.data());
    P_ = x.impulse;
    double share = 1;
    for (int k = 0; k < 12; ++k, share *= 0.5) {
      for (int r = 0; r < rows; ++r) x.impulse[r] = P_[r] + share * step_[place_[r]];
      if (project(x, false, 0) < before) break;
    }
  }
  return {x.residual() <= std::max(accepted, x.attainable()), steps};
}

bool BandNewton::hold(SparseIsland& x) {
  const int rows = static_cast<int>(x.slots.size()), width = order(x);
  if (static_cast<double>(rows) * width * width > most_operations) return false;
  step_.resize(x.slots.size());
  for (const double proximal : {0.0, 1e-9, 1e-6}) {
    band_.begin(rows, width);
    for (int r = 0; r < rows; ++r) {
      const double d = x.entry(r, r), rho = d > 0 ? 1 / d : 0;
      for (int e = x.begin[r]; e < x.begin[r + 1]; ++e)
        band_.at(place_[r], place_[x.column[e]]) = rho * x.value[e];
      band_.at(place_[r], place_[r]) += d > 0 ? proximal : 1;
      step_[place_[r]] = -rho * x.b[r];
    }
    if (!band_.factor(1e-11)) continue;
    band_.solve(step_.data());
    x.impulse.resize(x.slots.size());
    for (int r = 0; r < rows; ++r) x.impulse[r] = step_[place_[r]];
    return std::ranges::all_of(x.impulse, [](double impulse) { return std::isfinite(impulse); });
  }
  return false;
}

}  // namespace freeplay
