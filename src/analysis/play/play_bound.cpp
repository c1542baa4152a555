#include "analysis/play/play_bound.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace freeplay {
namespace {

/// Upper bound of Σ σ_k over shifts σ ≥ 0 of the components that make C + R negative semidefinite, R ≥ 0 being
/// the radius of an enclosure.
///
/// Rows that their diagonal dominates need none, and of the others it suffices to shift (weak rows w)
///
///     C_ww + R_ww + Σ_s N (|C_sw| + R_sw)²/m_s,   m_s: what dominates in row s,   N: number of weak rows,
///
/// because 2 x y ≤ N x²/m + m y²/N. Its greatest eigenvalue is bounded by that of the centre and row sums of R.
double shift(const Eigen::MatrixXd& C, const Eigen::MatrixXd& R,
             const std::vector<LooseComponent>& components) {
  const Eigen::MatrixXd size = C.cwiseAbs() + R;
  const auto excess = [&](int i, const std::vector<int>& rows) {
    double sum = C(i, i) + R(i, i);
    for (const int j : rows)
      if (j != i) sum += size(i, j);
    return sum;
  };
  std::vector<int> all(static_cast<std::size_t>(C.rows())), weak, strong;
  std::iota(all.begin(), all.end(), 0);
  double by_discs = 0;
  int shifted = 0;
  for (const auto& component : components) {
    double most = 0;
    for (int i = component.first; i < component.first + component.size(); ++i)
      most = std::max(most, excess(i, all));
    by_discs += most;
    shifted += most > 0;
    for (int i = component.first; i < component.first + component.size(); ++i)
      (most > 0 ? weak : strong).push_back(i);
  }
  if (weak.empty()) return 0;
  const auto count = static_cast<Eigen::Index>(weak.size());
  Eigen::MatrixXd centre(count, count);
  double radius = 0;
  for (Eigen::Index a = 0; a < count; ++a) {
    const int i = weak[static_cast<std::size_t>(a)];
    double row = 0;
    for (Eigen::Index b = 0; b < count; ++b) {
      const int j = weak[static_cast<std::size_t>(b)];
      centre(a, b) = C(i, j);
      row += R(i, j);
    }
    radius = std::max(radius, row);
    for (const int j : strong) {
      const double margin = -excess(j, strong);  // positive: row j dominates in all columns
      centre(a, a) += static_cast<double>(count) * size(i, j) * size(i, j) / margin;
    }
  }
  const double by_eigenvalue = std::max(0.0, symmetric_eigen(centre).values.maxCoeff() + radius);
  return std::min(by_discs, by_eigenvalue * shifted);
}

}  // namespace

double excess(PlayOutput& h, const PlayExtreme& x) {
  const auto& components = h.mechanism.components();
  const auto& box = h.region.derivatives;
  const int n = h.mechanism.n(), m = h.mechanism.size();
  // λ belongs to x; p(q*) − y(q*) = −λᵀF is rounding.
  double more = std::abs(h.lambda.dot(h.f.F));
  Eigen::VectorXd alpha = Eigen::VectorXd::Zero(m);
  for (const auto& c : components) {
    const auto u = x.u.segment(c.first, c.size()), a = x.a.segment(c.first, c.size());
    const double along = a.dot(u) / std::max(u.squaredNorm(), 1e-300), full = std::abs(u.norm() - 1);
    if (full > 1e-12 || along < 0) {
      more += 2 * a.norm();
      continue;
    }
    alpha.segment(c.first, c.size()).setConstant(along);
    more += 2 * (a - along * u).norm();
  }
  // δq = S δu: (v_q − u* w_q) δq = (c or w) δu over the box; |A B − I| ≤ N gives |δq − S₀ δu| ≤ T |δu| with
  // T = |A| rad + N (|S₀| + T), a series in N.
  Eigen::MatrixXd by_q = box.by_q, by_q_radius = box.by_q_radius, by_u = h.f.by_u;
  Eigen::MatrixXd by_u_radius = Eigen::MatrixXd::Zero(n, m);
  for (std::size_t i = 0; i < components.size(); ++i) {
    const auto& c = components[i];
    const auto row = static_cast<Eigen::Index>(i);
    if (c.disc) continue;
    by_q.row(c.row) -= x.u[c.first] * box.width_by_q.row(row);
    by_q_radius.row(c.row) += std::abs(x.u[c.first]) * box.width_by_q_radius.row(row);
    by_u(c.row, c.first) = -h.region.width[row];
    by_u_radius(c.row, c.first) = h.region.width_change[row];
  }
  const Eigen::MatrixXd A = solve_columns(h.factors, Eigen::MatrixXd::Identity(n, n)), S = -(A * by_u);
  const Eigen::MatrixXd N =
      (Eigen::MatrixXd::Identity(n, n) - A * by_q).cwiseAbs() + A.cwiseAbs() * by_q_radius;
  Eigen::MatrixXd power = A.cwiseAbs() * by_u_radius + N * S.cwiseAbs(), T = power;
  constexpr int terms = 60;
  for (int i = 0; i < terms && power.maxCoeff() > 1e-17 * T.maxCoeff(); ++i) {
    power = N * power;
    T += power;
  }
  if (power.maxCoeff() > 1e-10 * T.maxCoeff()) return INFINITY;
  T *= 1 + 1e-9;
  Eigen::MatrixXd second, second_radius;
  h.mechanism.enclose_second(h.k, h.sign, h.lambda, x.u, second, second_radius);
  const Eigen::MatrixXd P = second.topLeftCorner(n, n), P_radius = second_radius.topLeftCorner(n, n);
  const Eigen::MatrixXd X = second.topRightCorner(n, m), X_radius = second_radius.topRightCorner(n, m);
  Eigen::MatrixXd C = S.transpose() * P * S + S.transpose() * X + X.transpose() * S;
  const Eigen::MatrixXd size = S.cwiseAbs() + T, P_size = P.cwiseAbs() + P_radius,
                        X_size = X.cwiseAbs() + X_radius;
  const Eigen::MatrixXd error = T.transpose() * P_size * size;
  const Eigen::MatrixXd cross = T.transpose() * X_size + S.cwiseAbs().transpose() * X_radius;
  Eigen::MatrixXd R = S.cwiseAbs().transpose() * P_radius * S.cwiseAbs() + error + error.transpose() + cross +
                      cross.transpose();
  C = 0.5 * (C + C.transpose()).eval();
  R = 0.5 * (R + R.transpose()).eval();
  C.diagonal() -= alpha;
  more += 2 * shift(C, R, components);
  // Rounding of y and of its terms.
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  return more + 4 * epsilon * std::abs(x.value);
}

}  // namespace freeplay
