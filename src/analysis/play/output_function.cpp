#include "analysis/play/output_function.hpp"

namespace freeplay {

bool OutputFunction::evaluate(const Eigen::VectorXd& u, Eigen::VectorXd& q) {
  if (!mechanism.close(u, region.t, q, f, factors)) return false;
  value = sign * mechanism.output(k, gradient_);
  gradient_ *= sign;
  DenseLu transposed;
  transposed.compute(f.by_q.transpose());
  transposed.solve(gradient_, lambda);
  a = -(f.by_u.transpose() * lambda);
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
