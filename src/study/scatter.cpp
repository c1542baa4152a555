#include "study/scatter.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

void Scatter::add(const Eigen::VectorXd& xi, const Eigen::MatrixXd& outcomes) {
  if (outcomes.rows() < 2) return;
  const Eigen::RowVectorXd mean = outcomes.colwise().mean();
  const Eigen::MatrixXd r = (outcomes.rowwise() - mean).array().rowwise() / mean.array();
  points_.push_back({xi, r.transpose() * r, static_cast<double>(outcomes.rows() - 1)});
}

Scatter::Local Scatter::at(const Eigen::VectorXd& xi) const {
  const auto m = points_.front().squares.rows();
  const double width = 0.25 * static_cast<double>(xi.size());  // h²
  Local local{Eigen::MatrixXd::Zero(m, m), 0};
  double weight = 0, squares = 0;
  for (const auto& p : points_) {
    const double k = std::exp(-0.5 * (xi - p.xi).squaredNorm() / width);
    local.covariance += k * p.squares;
    weight += k * p.freedom;
    squares += k * k * p.freedom;
  }
  local.covariance /= weight;
  local.freedom = weight * weight / squares;
  const Eigen::VectorXd s = local.covariance.diagonal().cwiseSqrt();
  double numerator = 0, denominator = 0;
  const auto correlation = [&](Eigen::Index i, Eigen::Index j) {
    return s[i] > 0 && s[j] > 0 ? local.covariance(i, j) / (s[i] * s[j]) : 0.0;
  };
  for (Eigen::Index i = 0; i < m; ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      const double r = correlation(i, j);
      numerator += std::pow(1 - r * r, 2) / local.freedom;
      denominator += r * r;
    }
  const double kept = denominator > 0 ? 1 - std::min(1.0, numerator / denominator) : 0;
  for (Eigen::Index i = 0; i < m; ++i)
    for (Eigen::Index j = 0; j < m; ++j)
      if (i != j) local.covariance(i, j) *= kept;
  return local;
}

}  // namespace freeplay
