#include "analysis/play/output_function.hpp"

#include <cmath>
#include <limits>

#include "dynamics/planar.hpp"

namespace freeplay {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

}  // namespace

bool OutputFunction::evaluate(const Eigen::VectorXd& u, Eigen::VectorXd& q) {
  if (!mechanism.close(u, region.t, q, f, factors)) return false;
  value = sign * mechanism.output(k, gradient_);
  gradient_ *= sign;
  DenseLu transposed;
  transposed.compute(f.by_q.transpose());
  transposed.solve(gradient_, lambda);
  a = -(f.by_u.transpose() * lambda);
  // λᵀF is the change of h by which F would vanish. The terms of F and y are as large as coordinates and arms, and
  // F_q and ∇y are their sizes in the units of the coordinates.
  Eigen::VectorXd size = q.cwiseAbs();
  for (Eigen::Index c = 0; c < size.size(); ++c)
    size[c] += c % planar::coordinates == 2 ? 1 : mechanism.length();
  const Eigen::VectorXd terms = f.by_q.cwiseAbs().transpose() * lambda.cwiseAbs() + gradient_.cwiseAbs();
  rounding = std::abs(lambda.dot(f.F)) + epsilon * (4 * std::abs(value) + terms.dot(size));
  return true;
}

bool OutputFunction::evaluate(const Eigen::VectorXd& u) {
  pose_ = region.q + region.slope * u;
  return evaluate(u, pose_);
}

Eigen::MatrixXd OutputFunction::second(const Eigen::VectorXd& u) {
  const int n = mechanism.n(), m = mechanism.size();
  const Eigen::MatrixXd S = -solve_columns(factors, f.by_u);
  Eigen::MatrixXd H;
  mechanism.second(k, sign, lambda, u, H);
  const Eigen::MatrixXd cross = S.transpose() * H.topRightCorner(n, m);
  return S.transpose() * H.topLeftCorner(n, n) * S + cross + cross.transpose();
}

}  // namespace freeplay
