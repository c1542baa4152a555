// The exact Jacobian of a right-hand side against central differences.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/penalty/dynamics.hpp"
#include "mechanism/scene.hpp"

namespace freeplay::test {

/// Greatest difference of an entry of f.jacobian(x, t), by x and by t, over the greatest of its row
/// (1e-3 at least). Differences are of Richardson's form from steps s and s/2 with s = 2e-4: their
/// error is of s⁴ times fifth derivatives plus rounding ε/s, both below 1e-6 of the greatest entry
/// for functions and states of order one.
template <class Dynamics>
double jacobian_error(Dynamics& f, const typename Dynamics::Vector& x, double t) {
  using Vector = typename Dynamics::Vector;
  const int N = f.size();
  const auto n = static_cast<std::size_t>(N);
  std::vector<double> J(n * n), dfdt(n);
  f.jacobian(x, t, J.data(), dfdt.data());
  const auto difference = [&](std::size_t j, double s) {
    Vector lo = x, hi = x, a(n), b(n);
    double ta = t, tb = t;
    (j < n ? lo[j] : ta) -= s;
    (j < n ? hi[j] : tb) += s;
    f(lo, a, ta);
    f(hi, b, tb);
    for (std::size_t i = 0; i < n; ++i) a[i] = (b[i] - a[i]) / (2 * s);
    return a;
  };
  std::vector<Vector> columns;
  std::vector<double> greatest(n, 1e-3);
  for (std::size_t j = 0; j <= n; ++j) {
    auto column = difference(j, 2e-4);
    const auto fine = difference(j, 1e-4);
    for (std::size_t i = 0; i < n; ++i) {
      column[i] = (4 * fine[i] - column[i]) / 3;
      greatest[i] = std::max(greatest[i], std::abs(column[i]));
    }
    columns.push_back(column);
  }
  double worst = 0;
  for (std::size_t j = 0; j <= n; ++j)
    for (std::size_t i = 0; i < n; ++i) {
      const double exact = j < n ? J[j * n + i] : dfdt[i];
      worst = std::max(worst, std::abs(exact - columns[j][i]) / greatest[i]);
    }
  return worst;
}

/// The same for the penalty formulation at 0.4 s, in `count` random states.
inline double jacobian_error(const Scene& scene, unsigned seed, int count = 1) {
  const System system(scene.mechanism);
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  double worst = 0;
  for (int i = 0; i < count; ++i) {
    PenaltyDynamics f(system, scene.penalty, {}, RowFacts{false});
    PenaltyDynamics::Vector x(static_cast<std::size_t>(f.size()));
    for (auto& y : x) y = uniform(engine);
    f.phases.start(system, x.data(), x.data() + system.n());
    worst = std::max(worst, jacobian_error(f, x, 0.4));
  }
  return worst;
}

}  // namespace freeplay::test
