#include "dynamics/assembly/projection.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/system.hpp"
#include "values/state.hpp"

namespace freeplay {
namespace {

/// Rows closer than this to the span of others, relative, are dependent.
constexpr double dependent = 1e-9;

/// v += M^(−1/2) x, with x the shortest solution of rowsᵀ x = wanted.
void change_least(const System& system, const Eigen::MatrixXd& rows, const Eigen::VectorXd& wanted,
                  std::vector<double>& v) {
  const auto x = MinimumNorm(rows.transpose(), dependent).solve(wanted);
  for (std::size_t c = 0; c < v.size(); ++c)
    v[c] += x[static_cast<Eigen::Index>(c)] / std::sqrt(system.mass()[c]);
}

}  // namespace

Eigen::MatrixXd weighted_rows(const System& system, const std::vector<int>& contacts, const State& s) {
  auto e = system.make_evaluation();
  system.place(s.t, s.q.data(), e);
  const auto& pattern = system.pattern();
  const auto weighted = [&](int column, double value) {
    return value / std::sqrt(system.mass()[static_cast<std::size_t>(column)]);
  };
  Eigen::MatrixXd rows =
      Eigen::MatrixXd::Zero(system.n(), system.rows() + static_cast<Eigen::Index>(contacts.size()));
  for (int k = 0; k < system.rows(); ++k)
    for (int i = pattern.begin[k]; i < pattern.begin[k + 1]; ++i)
      rows(pattern.column[i], k) += weighted(pattern.column[i], e.G[i]);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ContactRow row;
    system.contact(contacts[k], s.q.data(), s.v.data(), e, row);
    for (int i = 0; i < row.normal.size; ++i)
      rows(row.normal.column[i], system.rows() + static_cast<Eigen::Index>(k)) +=
          weighted(row.normal.column[i], row.normal.value[i]);
  }
  return rows;
}

bool project_onto_constraints(const System& system, const std::vector<int>& contacts, State& s) {
  constexpr int most = 20;
  constexpr double nearly_closed = 1e-12;  // m or rad
  if (system.rows() == 0 && contacts.empty()) return true;
  auto e = system.make_evaluation();
  const Eigen::Index m = system.rows();
  Eigen::VectorXd wanted(m + static_cast<Eigen::Index>(contacts.size()));
  double last = INFINITY;
  for (int i = 0;; ++i) {
    system.place(s.t, s.q.data(), e);
    for (Eigen::Index k = 0; k < m; ++k) wanted[k] = -e.phi[static_cast<std::size_t>(k)];
    for (std::size_t k = 0; k < contacts.size(); ++k)
      wanted[m + static_cast<Eigen::Index>(k)] = -system.gap(contacts[k], s.q.data(), e);
    const double open = wanted.cwiseAbs().maxCoeff();
    if (!std::isfinite(open) || i == most) return false;
    // Newton's method doubles the digits: one step beyond this residual reaches rounding.
    if (open == 0 || std::max(open, last) < nearly_closed) break;
    last = open;
    change_least(system, weighted_rows(system, contacts, s), wanted, s.q);
  }
  const auto rows = weighted_rows(system, contacts, s);
  Eigen::VectorXd rates(static_cast<Eigen::Index>(s.v.size()));
  for (int i = 0; i < 2; ++i) {  // the second pass removes the rounding of the first
    for (std::size_t c = 0; c < s.v.size(); ++c)
      rates[static_cast<Eigen::Index>(c)] = s.v[c] * std::sqrt(system.mass()[c]);
    wanted = -(rows.transpose() * rates);
    for (Eigen::Index k = 0; k < m; ++k) wanted[k] -= e.phi_t[static_cast<std::size_t>(k)];
    change_least(system, rows, wanted, s.v);
  }
  return true;
}

}  // namespace freeplay
