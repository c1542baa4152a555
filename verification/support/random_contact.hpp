// Random contact problems whose solution is unique, for the tests and the claims.
#pragma once

#include <algorithm>
#include <random>

#include "formulations/contact/contact_problem.hpp"

namespace freeplay::test {

struct Random {
  std::mt19937 engine{20261121};
  double operator()(double lo = -1, double hi = 1) {
    return std::uniform_real_distribution<double>(lo, hi)(engine);
  }
};

/// `contacts` contacts, some without friction, and sometimes a preloaded joint.
inline ContactProblem random_problem(Random& u, int contacts, bool friction) {
  ContactProblem p;
  p.reserve(2 * contacts + 1);
  for (int i = 0; i < contacts; ++i) {
    ContactUnknown c;
    c.normal = p.rows++;
    c.target_n = std::max(0.0, u());
    if (friction && u() > -0.5) {
      c.tangent = p.rows++;
      c.friction = u(0, 0.3) / contacts;
      c.target_t = u() > 0 ? u() : 0;
    }
    p.unknowns.push_back(c);
  }
  if (friction && u() > 0) {
    ContactUnknown c;
    c.tangent = p.rows++;
    c.bound = u(0, 1);
    p.unknowns.push_back(c);
  }
  const int m = p.rows;
  const Eigen::MatrixXd R = Eigen::MatrixXd::NullaryExpr(m, m + 1, [&] { return u(); });
  p.D.topLeftCorner(m, m) = R * R.transpose() / m + 0.3 * Eigen::MatrixXd::Identity(m, m);
  for (int i = 0; i < m; ++i) p.b[i] = u();
  return p;
}

inline ContactSolution solve_by(LcpSolver solver, ContactProblem& p) {
  ContactProblem q(solver);
  q.reserve(static_cast<int>(p.D.rows()));
  q.unknowns = p.unknowns;
  q.rows = p.rows;
  q.D = p.D;
  q.b = p.b;
  const auto result = q.solve();
  p.unknowns = q.unknowns;
  return result;
}

}  // namespace freeplay::test
