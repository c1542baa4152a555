#include "analysis/play/play_bound.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace freeplay {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A matrix within centre ± radius.
struct Enclosed {
  MatrixXd centre, radius;
  MatrixXd size() const { return centre.cwiseAbs() + radius; }
};

/// Shifts of the rows, σ ≥ 0, that make C + R negative semidefinite, R ≥ 0 being the radius of an enclosure.
///
/// Rows that their diagonal dominates need none, and of the others it suffices to shift (weak rows w)
///
///     C_ww + R_ww + Σ_s N (|C_sw| + R_sw)²/m_s,   m_s: what dominates in row s,   N: number of weak rows,
///
/// because 2 x y ≤ N x²/m + m y²/N. Its greatest eigenvalue is bounded by that of the centre and row sums of R.
VectorXd shifts(const Enclosed& M) {
  const MatrixXd& C = M.centre;
  const MatrixXd& R = M.radius;
  const MatrixXd size = M.size();
  const auto excess = [&](int i, const std::vector<int>& rows) {
    double sum = C(i, i) + R(i, i);
    for (const int j : rows)
      if (j != i) sum += size(i, j);
    return sum;
  };
  std::vector<int> all(static_cast<std::size_t>(C.rows())), weak, strong;
  std::iota(all.begin(), all.end(), 0);
  VectorXd by_rows = VectorXd::Zero(C.rows());
  for (const int i : all) {
    by_rows[i] = std::max(0.0, excess(i, all));
    (by_rows[i] > 0 ? weak : strong).push_back(i);
  }
  if (weak.empty()) return by_rows;
  const auto count = static_cast<Eigen::Index>(weak.size());
  MatrixXd centre(count, count);
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
      if (size(i, j) == 0) continue;
      const double margin = -excess(j, strong);  // positive: row j dominates in all columns
      if (!(margin > 0)) return by_rows;
      centre(a, a) += static_cast<double>(count) * size(i, j) * size(i, j) / margin;
    }
  }
  const double by_eigenvalue = std::max(0.0, symmetric_eigen(centre).values.maxCoeff() + radius);
  if (by_eigenvalue * static_cast<double>(count) >= by_rows.sum()) return by_rows;
  VectorXd shifted = VectorXd::Zero(C.rows());
  for (const int i : weak) shifted[i] = by_eigenvalue;
  return shifted;
}

/// What is enclosed about x.
struct Enclosure {
  LooseMechanism::Enclosures derivatives;
  VectorXd width, width_change;  ///< w within width ± width_change
  Enclosed slope;                ///< S̃
  MatrixXd inverse;              ///< ≥ |F_q⁻¹|, at u*
};

/// Sets the slope and the inverse of `e`; false if the box is too large.
bool set_slopes(const OutputFunction& h, const PlayExtreme& x, Enclosure& e) {
  // |A F_q − I| ≤ N gives |F_q⁻¹| ≤ Σ Nⁱ |A| and |S̃ − S| ≤ Σ Nⁱ (|A| rad(w) + N |S|).
  const int n = h.mechanism.n(), m = h.mechanism.size();
  MatrixXd by_q = e.derivatives.by_q, by_q_radius = e.derivatives.by_q_radius, by_u = h.f.by_u;
  MatrixXd by_u_radius = MatrixXd::Zero(n, m);
  for (std::size_t i = 0; i < h.mechanism.components().size(); ++i) {
    const auto& c = h.mechanism.components()[i];
    const auto row = static_cast<Eigen::Index>(i);
    if (c.disc) continue;
    by_q.row(c.row) -= x.u[c.first] * e.derivatives.width_by_q.row(row);
    by_q_radius.row(c.row) += std::abs(x.u[c.first]) * e.derivatives.width_by_q_radius.row(row);
    by_u(c.row, c.first) = -e.width[row];
    by_u_radius(c.row, c.first) = e.width_change[row];
  }
  const MatrixXd unit = MatrixXd::Identity(n, n), A = solve_columns(h.factors, unit);
  e.slope.centre = -(A * by_u);
  const MatrixXd N = (unit - A * by_q).cwiseAbs() + A.cwiseAbs() * by_q_radius;
  MatrixXd power = unit, series = unit;
  constexpr int terms = 60;
  for (int i = 0; i < terms && power.maxCoeff() > 1e-17 * series.maxCoeff(); ++i) {
    power = N * power;
    series += power;
  }
  if (!(power.maxCoeff() <= 1e-10 * series.maxCoeff())) return false;
  series *= 1 + 1e-9;
  e.inverse = series * A.cwiseAbs();
  e.slope.radius = series * (A.cwiseAbs() * by_u_radius + N * e.slope.centre.cwiseAbs());
  return true;
}

/// The greatest |u_i − x.u_i| in the part.
VectorXd distances(const PlayPart& part, const VectorXd& u) {
  return (part.low - u).cwiseAbs().cwiseMax((part.high - u).cwiseAbs());
}

/// Encloses the poses of the part; `e` has the slopes of a larger one.
bool enclose_again(OutputFunction& h, const PlayExtreme& x, const VectorXd& d, Enclosure& e) {
  LooseMechanism::Poses poses;
  poses.q = x.q;
  poses.slope = e.slope.centre;
  const auto& components = h.mechanism.components();
  poses.beyond = e.slope.radius * d + 4e-16 * (x.q.cwiseAbs().array() + h.mechanism.length()).matrix();
  poses.radius = poses.beyond;
  for (const auto& c : components) {
    poses.slope.middleCols(c.first, c.size()) *= d.segment(c.first, c.size()).norm();
    poses.radius += poses.slope.middleCols(c.first, c.size()).rowwise().norm();
  }
  if (!h.mechanism.enclose(poses, h.region.t, e.derivatives)) return false;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const auto& c = components[i];
    const auto row = static_cast<Eigen::Index>(i);
    if (c.disc) continue;
    e.width[row] = -h.f.by_u(c.row, c.first);
    e.width_change[row] =
        (e.derivatives.width_by_q.row(row).cwiseAbs() + e.derivatives.width_by_q_radius.row(row))
            .dot(poses.radius.transpose());
  }
  return set_slopes(h, x, e);
}

/// S̃ᵀ P S̃ less diag blocks A, in units of d.
Enclosed quadratic(const Enclosed& P, const Enclosed& slope, const MatrixXd& A, const VectorXd& d) {
  const MatrixXd S = slope.centre * d.asDiagonal(), T = slope.radius * d.asDiagonal();
  const MatrixXd S_size = S.cwiseAbs(), error = T.transpose() * (P.size() * (S_size + T));
  Enclosed M{S.transpose() * P.centre * S, S_size.transpose() * P.radius * S_size + error};
  M.radius += (T.transpose() * (P.size() * S_size)).transpose();
  M.centre = 0.5 * (M.centre + M.centre.transpose()).eval();
  M.radius = 0.5 * (M.radius + M.radius.transpose()).eval();
  M.centre -= d.asDiagonal() * A * d.asDiagonal();
  return M;
}

/// A matrix without negative eigenvalues that P does not exceed, in units of `range` for its rows.
Enclosed positive_part(const Enclosed& P, const VectorXd& range) {
  MatrixXd most = range.asDiagonal() * P.centre * range.asDiagonal();
  most.diagonal() += range.cwiseProduct(P.radius * range);
  const auto eigen = symmetric_eigen(most);
  const MatrixXd positive = eigen.vectors * eigen.values.cwiseMax(0).asDiagonal() * eigen.vectors.transpose();
  const VectorXd scale = (range.array() > 0).select(range.cwiseInverse(), 0);
  return {scale.asDiagonal() * positive * scale.asDiagonal(),
          MatrixXd::Zero(P.centre.rows(), P.centre.cols())};
}

/// The linear terms: what they add at most, by entry of u, and half of the squares A by which they decrease h.
void linear_terms(const OutputFunction& h, const PlayExtreme& x, const Enclosure& e, const PlayPart& reach,
                  const VectorXd& d, VectorXd& most, MatrixXd& A) {
  most.setZero(x.u.size());
  A.setZero(x.u.size(), x.u.size());
  constexpr double on_rim = 1e-12, least = 1e-200;
  const auto add = [&](int i, double r_low, double r_high) {  // r_i δu_i, with r_i of one sign
    const double up = std::max(r_high * (reach.high[i] - x.u[i]), r_high * (reach.low[i] - x.u[i]));
    if (up > 0)
      most[i] += up;
    else if (d[i] > least)
      A(i, i) += 2 * std::abs(r_low) / d[i];
  };
  for (std::size_t k = 0; k < h.mechanism.components().size(); ++k) {
    const auto& c = h.mechanism.components()[k];
    if (!c.disc) {
      const double lambda = x.a[c.first] / -h.f.by_u(c.row, c.first);
      const auto row = static_cast<Eigen::Index>(k);
      add(c.first, lambda * std::max(0.0, e.width[row] - e.width_change[row]),
          lambda * (e.width[row] + e.width_change[row]));
      continue;
    }
    const Eigen::Vector2d u = x.u.segment<2>(c.first), a = x.a.segment<2>(c.first);
    const double alpha = std::abs(u.norm() - 1) < on_rim ? std::max(0.0, a.dot(u)) : 0;
    if (alpha > 0) {
      // ρ = −u·δu is at least ½ |δu|², and at least ρ²/depth.
      double depth = 0;
      for (int i = 0; i < 2; ++i)
        depth += std::max(u[i] * (u[i] - reach.low[c.first + i]), u[i] * (u[i] - reach.high[c.first + i]));
      const double share = depth < 1.9 ? 0.5 : 0;
      most[c.first] += alpha * std::abs(u.norm() - 1);
      auto block = A.block<2, 2>(c.first, c.first);
      block.diagonal().array() += (1 - share) * alpha;
      if (share > 0 && depth > least) block += share * alpha * 2 / depth * (u * u.transpose());
    }
    for (int i = 0; i < 2; ++i) {
      const double r = a[i] - alpha * u[i];
      add(c.first + i, r, r);
    }
  }
}

/// Restricts the reach to the farthest positions along the gradients in the box.
void restrict_reach(const OutputFunction& h, const PlayExtreme& x, const Enclosure& e, const Enclosed& P,
                    const VectorXd& d, const PlayPart& part, PlayPart& reach) {
  // |λ(q) − λ| ≤ Δ = |F_q⁻¹|ᵀ (|P| |δq| + Σ_k |w_k,q| |δu_k| (|λ_k| + Δ_k))
  const MatrixXd G = e.inverse.transpose();
  const VectorXd range = e.slope.size() * d;
  const VectorXd by_P = P.size() * range;
  const auto& components = h.mechanism.components();
  const auto next = [&](const VectorXd& Delta) -> VectorXd {
    VectorXd sum = by_P;
    for (std::size_t k = 0; k < components.size(); ++k)
      if (const auto& c = components[k]; !c.disc) {
        const auto row = static_cast<Eigen::Index>(k);
        sum += (std::abs(h.lambda[c.row]) + Delta[c.row]) * d[c.first] *
               (e.derivatives.width_by_q.row(row).cwiseAbs() + e.derivatives.width_by_q_radius.row(row))
                   .transpose();
      }
    return G * sum;
  };
  VectorXd Delta = VectorXd::Zero(h.mechanism.n());
  constexpr int rounds = 30;
  for (int i = 0; i < rounds; ++i) Delta = next(Delta);
  Delta *= 1.001;
  if (!(next(Delta).array() <= Delta.array()).all()) return;
  for (const auto& c : components) {
    PlayPart farthest = part;
    if (c.disc)
      farthest.restrict_to_farthest(c, x.a.segment(c.first, 2), c.clearance * Delta.segment(c.row, 2).norm());
    else
      farthest.restrict_to_farthest(c, h.lambda.segment(c.row, 1), Delta[c.row]);
    for (int i = c.first; i < c.first + c.size(); ++i) {
      reach.low[i] = std::max(reach.low[i], farthest.low[i]);
      reach.high[i] = std::min(reach.high[i], farthest.high[i]);
      if (reach.low[i] > reach.high[i]) std::swap(reach.low[i], reach.high[i]);  // rounding
    }
  }
}

}  // namespace

PartBound bound_on_part(OutputFunction& h, const PlayExtreme& x, const PlayPart& part, double accepted,
                        bool fresh) {
  constexpr int most = 8;
  constexpr double progress = 0.7;
  const int n = h.mechanism.n();
  PartBound found{INFINITY, part, 0};
  Enclosure e{h.region.derivatives, h.region.width, h.region.width_change, {}, {}};
  if (!set_slopes(h, x, e)) return found;
  VectorXd d = distances(found.reach, x.u), linear;
  MatrixXd A, second, second_radius;
  for (int round = 0; round < most; ++round) {
    if (!(fresh && round == 0) && !enclose_again(h, x, d, e)) return found;
    h.mechanism.enclose_second(h.k, h.sign, h.lambda, x.u, second, second_radius);
    const Enclosed P{second.topLeftCorner(n, n), second_radius.topLeftCorner(n, n)};
    linear_terms(h, x, e, found.reach, d, linear, A);
    VectorXd sigma = shifts(quadratic(P, e.slope, A, d));
    const auto total = [&] { return linear.sum() + 0.5 * sigma.sum() + h.rounding; };
    if (total() > accepted) {
      const Enclosed positive = positive_part(P, e.slope.size() * d);
      if (const VectorXd other = shifts(quadratic(positive, e.slope, A, d)); other.sum() < sigma.sum())
        sigma = other;
    }
    if (total() < found.excess) {
      found.excess = total();
      (linear + 0.5 * sigma).maxCoeff(&found.worst);
    }
    if (found.excess <= accepted) return found;
    restrict_reach(h, x, e, P, d, part, found.reach);
    const VectorXd last = d;
    d = distances(found.reach, x.u);
    if ((d.array() > progress * last.array()).all()) return found;
  }
  return found;
}

}  // namespace freeplay
