#include "study/surface.hpp"

#include <boost/random/sobol.hpp>
#include <cmath>
#include <stdexcept>

namespace freeplay {

Eigen::VectorXd ResponseSurface::basis(const Eigen::VectorXd& xi) {
  const auto n = xi.size();
  Eigen::VectorXd b(coefficients(static_cast<int>(n)));
  Eigen::Index k = 0;
  b[k++] = 1;
  for (Eigen::Index i = 0; i < n; ++i) b[k++] = xi[i];
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i; j < n; ++j) b[k++] = xi[i] * xi[j];
  return b;
}

ResponseSurface::ResponseSurface(const Eigen::MatrixXd& points, const Eigen::VectorXd& outcomes)
    : n_(static_cast<int>(points.cols())) {
  const auto m = points.rows();
  if (m < coefficients(n_) + 2) throw std::invalid_argument("too few points for a quadratic surface");
  Eigen::MatrixXd A(m, coefficients(n_));
  for (Eigen::Index i = 0; i < m; ++i) A.row(i) = basis(points.row(i).transpose()).transpose();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(A);
  coefficients_ = qr.solve(outcomes);
  const Eigen::MatrixXd Q = qr.householderQ() * Eigen::MatrixXd::Identity(m, A.cols());
  const Eigen::VectorXd residual = outcomes - A * coefficients_;
  double press = 0;
  for (Eigen::Index i = 0; i < m; ++i) {
    const double left_out = residual[i] / (1 - Q.row(i).squaredNorm());
    press += left_out * left_out;
  }
  error_ = std::sqrt(press / static_cast<double>(m));
  spread_ = std::sqrt((outcomes.array() - outcomes.mean()).square().sum() / static_cast<double>(m - 1));
}

Eigen::VectorXd ResponseSurface::gradient(const Eigen::VectorXd& xi) const {
  Eigen::VectorXd g = coefficients_.segment(1, n_);
  return g + hessian() * xi;
}

Eigen::MatrixXd ResponseSurface::hessian() const {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n_, n_);
  Eigen::Index k = n_ + 1;
  for (int i = 0; i < n_; ++i)
    for (int j = i; j < n_; ++j, ++k) {
      H(i, j) += coefficients_[k];
      H(j, i) += coefficients_[k];
    }
  return H;
}

Eigen::MatrixXd space_filling(int unknowns, int count) {
  boost::random::sobol engine(static_cast<std::size_t>(unknowns));
  Eigen::MatrixXd points(count, unknowns);
  const double range = static_cast<double>(boost::random::sobol::max());
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < unknowns; ++j) points(i, j) = 2 * (static_cast<double>(engine()) / range) - 1;
  return points;
}

}  // namespace freeplay
