// Solvers of the contact problem that work on its cases: enumeration, Gauss–Seidel over contacts, and a
// semismooth Newton method.
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "formulations/contact/contact_problem.hpp"

namespace freeplay {

/// Every combination of open, stick, slip right and slip left: a small linear system for each, taken when it
/// leaves no residual. The case of the impulses given comes first, since from step to step it mostly stays;
/// of the others the first, where sticking comes before slipping.
bool ContactProblem::enumerate(double accepted, int& cases) {
  constexpr int most = 2 * most_for_enumeration;
  const int n = static_cast<int>(unknowns.size());
  if (n > most_for_enumeration) return false;
  enum { open, stick, right, left };  // of a preloaded joint: open is not a case
  std::array<int, most_for_enumeration> state{};
  const auto first = [&](int i) { return unknowns[i].normal < 0 ? stick : open; };
  const auto last = [&](int i) { return unknowns[i].tangent < 0 ? stick : left; };
  bool given = true;
  for (int i = 0; i < n; ++i) {
    const auto& c = unknowns[i];
    const double bound = (c.bound + c.friction * c.impulse_n) * (1 - 1e-9);
    if (c.normal >= 0 && c.impulse_n <= 0)
      state[i] = open;
    else if (c.tangent < 0 || std::abs(c.impulse_t) < bound)
      state[i] = stick;
    else
      state[i] = c.impulse_t < 0 ? right : left;
  }
  Eigen::Matrix<double, -1, -1, 0, most, most> K;
  Eigen::Matrix<double, -1, 1, 0, most, 1> x;
  std::array<int, most> equation{};

  for (;;) {
    ++cases;
    // Rows that are to vanish, and their unknown impulses in the same order.
    int m = 0;
    for (int i = 0; i < n; ++i) {
      if (unknowns[i].normal >= 0 && state[i] != open) equation[m++] = unknowns[i].normal;
      if (unknowns[i].tangent >= 0 && state[i] == stick) equation[m++] = unknowns[i].tangent;
    }
    K.resize(m, m);
    x.resize(m);
    for (int r = 0; r < m; ++r) {
      const int row = equation[r];
      double rest = b[row];
      int column = 0;
      for (int i = 0; i < n; ++i) {
        const auto& c = unknowns[i];
        if (row == c.normal) rest -= c.target_n;
        if (row == c.tangent) rest -= c.target_t;
        const double side = state[i] == right ? -1 : state[i] == left ? 1 : 0;  // of the friction
        if (c.tangent >= 0 && side != 0) rest += D(row, c.tangent) * side * c.bound;
        if (c.normal >= 0 && state[i] != open)
          K(r, column++) = D(row, c.normal) + (side != 0 ? side * c.friction * D(row, c.tangent) : 0);
        if (c.tangent >= 0 && state[i] == stick) K(r, column++) = D(row, c.tangent);
      }
      x[r] = -rest;
    }
    if (m > 0) x = K.partialPivLu().solve(x).eval();
    int column = 0;
    for (int i = 0; i < n; ++i) {
      auto& c = unknowns[i];
      const double side = state[i] == right ? -1 : state[i] == left ? 1 : 0;
      c.impulse_n = c.normal >= 0 && state[i] != open ? x[column++] : 0;
      if (c.tangent >= 0)
        c.impulse_t = state[i] == stick ? x[column++] : side * (c.bound + c.friction * c.impulse_n);
    }
    if (residual() <= accepted) return true;
    if (given) {
      given = false;
      for (int j = 0; j < n; ++j) state[j] = first(j);
      continue;
    }
    int i = 0;
    for (; i < n; ++i) {
      if (state[i] < last(i)) {
        ++state[i];
        break;
      }
      state[i] = first(i);
    }
    if (i == n) return false;
  }
}

/// Contact by contact, each solved exactly with the others held, from the impulses given (Jourdan, Alart,
/// Jean, Comput. Methods Appl. Mech. Eng. 155 (1998) 31).
bool ContactProblem::gauss_seidel(double accepted, int& sweeps, int most) {
  q_.conservativeResize(std::max<Eigen::Index>(q_.size(), rows));
  for (const auto& c : unknowns)
    for (const int row : {c.normal, c.tangent})
      if (row >= 0) q_[row] = rate(row);
  const auto change = [&](int column, double by) {
    if (column >= 0 && by != 0) q_.head(rows) += by * D.col(column).head(rows);
  };
  for (int sweep = 0; sweep < most; ++sweep) {
    ++sweeps;
    double moved = 0;
    for (auto& c : unknowns) {
      const int n = c.normal, t = c.tangent;
      const double Pn = c.impulse_n, Pt = c.impulse_t, Dnn = n >= 0 ? D(n, n) : 0, Dtt = t >= 0 ? D(t, t) : 0,
                   Dnt = n >= 0 && t >= 0 ? D(n, t) : 0;
      const double bn = n >= 0 ? q_[n] - Dnn * Pn - Dnt * Pt : 0;
      const double bt = t >= 0 ? q_[t] - Dtt * Pt - Dnt * Pn : 0;
      if (!solve_one(c, bn, bt, Dnn, Dnt, Dtt)) return false;
      change(n, c.impulse_n - Pn);
      change(t, c.impulse_t - Pt);
      moved = std::max({moved, Dnn * std::abs(c.impulse_n - Pn), Dtt * std::abs(c.impulse_t - Pt)});
    }
    if (moved <= 0.1 * accepted && residual() <= accepted) return true;
  }
  return false;
}

/// Newton's method on the projections P_N = (P_N − ρ u_N)⁺, P_T = clamp(P_T − ρ u_T, ±bound) (Alart and
/// Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353), the step halved while it does not help.
bool ContactProblem::newton(double accepted, int& steps, From from) {
  const int most = from == From::nothing ? 100 : from == From::given ? 20 : 4;
  constexpr int few = 24;  // rows that stand on the stack: no step of a small mechanism takes memory
  const auto within = [&]<int room>(std::integral_constant<int, room>) {
    using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, room, 1>;
    using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, room, room>;
    Vector F(rows), P(rows), step(rows);
    Matrix J(rows, rows);
    const auto gather = [&] {
      for (const auto& c : unknowns) {
        if (c.normal >= 0) P[c.normal] = c.impulse_n;
        if (c.tangent >= 0) P[c.tangent] = c.impulse_t;
      }
    };
    const auto scatter = [&](const Vector& x) {
      for (auto& c : unknowns) {
        if (c.normal >= 0) c.impulse_n = x[c.normal];
        if (c.tangent >= 0) c.impulse_t = x[c.tangent];
      }
    };
    const auto evaluate = [&](bool with_jacobian) {
      for (const auto& c : unknowns) {
        const int n = c.normal, t = c.tangent;
        bool pressed = false;
        if (n >= 0) {
          const double rho = 1 / D(n, n), trial = c.impulse_n - rho * (rate(n) - c.target_n);
          pressed = trial > 0;
          F[n] = c.impulse_n - (pressed ? trial : 0);
          if (with_jacobian) {
            J.row(n).setZero();
            if (pressed)
              J.row(n) = rho * D.row(n).head(rows);
            else
              J(n, n) = 1;
          }
        }
        if (t < 0) continue;
        const double rho = 1 / D(t, t), bound = c.bound + c.friction * std::max(0.0, c.impulse_n);
        const double trial = c.impulse_t - rho * (rate(t) - c.target_t);
        const double kept = std::clamp(trial, -bound, bound);
        F[t] = c.impulse_t - kept;
        if (!with_jacobian) continue;
        J.row(t).setZero();
        if (kept == trial) {
          J.row(t) = rho * D.row(t).head(rows);
        } else {
          J(t, t) = 1;
          if (n >= 0 && c.impulse_n > 0) J(t, n) = trial > 0 ? -c.friction : c.friction;
        }
      }
      return F.squaredNorm();
    };
    if (from == From::nothing)
      for (auto& c : unknowns) c.impulse_n = c.impulse_t = 0;
    for (int i = 0; i < most; ++i) {
      ++steps;
      const double before = evaluate(true);
      if (residual() <= accepted) return true;
      if (!std::isfinite(before)) return false;
      gather();
      const Eigen::PartialPivLU<Matrix> lu(J);
      const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
      if (pivots.minCoeff() > 1e-12 * pivots.maxCoeff()) {
        step = -lu.solve(F);
      } else if (from == From::last) {
        return false;
      } else {  // forces are not unique: the least change of them
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
  return rows <= few ? within(std::integral_constant<int, few>())
                     : within(std::integral_constant<int, Eigen::Dynamic>());
}

bool ContactProblem::newton_from_last(double accepted, int& steps) {
  if (std::ranges::none_of(unknowns, [](const auto& c) { return c.impulse_n > 0 || c.impulse_t != 0; }))
    return false;
  last_.clear();
  for (const auto& c : unknowns) last_.push_back({c.impulse_n, c.impulse_t});
  if (newton(accepted, steps, From::last)) return true;
  for (std::size_t i = 0; i < last_.size(); ++i) {
    unknowns[i].impulse_n = last_[i][0];
    unknowns[i].impulse_t = last_[i][1];
  }
  return false;
}

}  // namespace freeplay
