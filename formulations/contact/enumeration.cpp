// Enumeration of the modes of a small contact problem.
#include <Eigen/LU>
#include <array>
#include <cmath>

#include "formulations/contact/solvers.hpp"

namespace freeplay {

/// Tries all combinations of open, stick, slip right and slip left. Each gives a small linear
/// system, whose solution is accepted if its residual is small enough. The mode of the initial
/// impulses comes first, because it rarely changes from step to step. Of the other modes the first
/// consistent one is taken; sticking precedes slipping.
SolverSummary enumeration(ContactEquations& p, double accepted, SolverRoom&) {
  auto& unknowns = p.unknowns;
  const auto& D = p.D;
  const auto& b = p.b;
  int cases = 0;
  constexpr int most = 2 * most_for_enumeration;
  const int n = static_cast<int>(unknowns.size());
  if (n > most_for_enumeration) return {false, cases};
  enum { open, stick, right, left };  // a preloaded joint has no open case
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
    // Rows whose rates vanish, and their unknown impulses in the same order.
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
        // sign of the friction impulse
        const double side = state[i] == right ? -1 : state[i] == left ? 1 : 0;
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
    if (p.residual() <= accepted) return {true, cases};
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
    if (i == n) return {false, cases};
  }
}

}  // namespace freeplay
