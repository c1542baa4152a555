#include "analysis/play/play_region.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

/// Greatest size of (row ± radius)(S u + A δ) over u ∈ U and |δ| ≤ η.
double spread(const LooseMechanism& mechanism, const Eigen::MatrixXd& S, const Eigen::RowVectorXd& row,
              const Eigen::RowVectorXd& radius, const Eigen::MatrixXd& A, const Eigen::VectorXd& eta) {
  const Eigen::RowVectorXd along = row * S, around = radius * S.cwiseAbs();
  double sum = (row * A).cwiseAbs().dot(eta.transpose()) + (radius * A.cwiseAbs()).dot(eta.transpose());
  for (const auto& c : mechanism.components())
    sum += along.segment(c.first, c.size()).norm() + around.segment(c.first, c.size()).norm();
  return sum;
}

}  // namespace

PlayRegion enclosed_poses(LooseMechanism& mechanism, const Eigen::VectorXd& q, double t) {
  const int n = mechanism.n(), m = mechanism.size();
  const auto& components = mechanism.components();
  const auto count = static_cast<Eigen::Index>(components.size());
  PlayRegion region;
  region.t = t, region.q = q;
  LooseMechanism::Equations f;
  DenseLu factors;
  auto& box = region.derivatives;
  if (!mechanism.close(Eigen::VectorXd::Zero(m), t, region.q, f, factors)) {
    region.refusal = "the ideal mechanism does not close here, or is at a dead centre";
    return region;
  }
  const Eigen::MatrixXd A = solve_columns(factors, Eigen::MatrixXd::Identity(n, n));
  region.slope = -(A * f.by_u);
  region.width.setZero(count), region.width_change.setZero(count);
  // s, and rounding
  Eigen::VectorXd first = 4e-16 * (region.q.cwiseAbs().array() + mechanism.length()).matrix();
  for (const auto& c : components)
    for (int i = 0; i < n; ++i) first[i] += region.slope.row(i).segment(c.first, c.size()).norm();
  Eigen::VectorXd eta = Eigen::VectorXd::Constant(n, 4e-16 * mechanism.length()), needed(n);
  for (const auto& c : components) eta.segment(c.row, c.size()).array() += 0.02 * c.clearance;
  constexpr int most = 25;
  for (int i = 0; i < most; ++i) {
    region.beyond = A.cwiseAbs() * eta;
    region.radius = first + region.beyond;
    if (!mechanism.enclose(region, t, box)) break;
    const Eigen::MatrixXd change = f.by_q - box.by_q;
    for (int row = 0; row < n; ++row)
      needed[row] = spread(mechanism, region.slope, change.row(row), box.by_q_radius.row(row), A, eta);
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto& c = components[static_cast<std::size_t>(k)];
      if (c.disc) continue;
      region.width[k] = -f.by_u(c.row, c.first);
      region.width_change[k] =
          spread(mechanism, region.slope, box.width_by_q.row(k), box.width_by_q_radius.row(k), A, eta);
      needed[c.row] += region.width_change[k];
    }
    if ((needed.array() <= eta.array()).all()) {
      for (Eigen::Index k = 0; k < count; ++k)
        if (const auto& c = components[static_cast<std::size_t>(k)];
            !c.disc && region.width_change[k] >= region.width[k])
          region.refusal = c.joint +
                           " may close on both sides at once within the other clearances and then "
                           "limits them, which is not described";
      return region;
    }
    eta = (1.05 * needed).cwiseMax(eta);
    if (!eta.allFinite() || (region.beyond.array() > 20 * first.array()).all()) break;
  }
  region.refusal = no_bound;
  return region;
}

}  // namespace freeplay
