#include "study/calibration/scatter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace freeplay {
namespace {

double weight(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& widths) {
  return std::exp(-0.5 * (a - b).cwiseQuotient(widths).squaredNorm());
}

constexpr std::array shares{0.2, 0.3, 0.45, 0.7, 1.0, 1.5};  // of ½√n

}  // namespace

void Scatter::add(const Eigen::VectorXd& xi, const Eigen::MatrixXd& outcomes) {
  if (outcomes.rows() < 2) return;
  if (points_.empty())
    widths_ = Eigen::VectorXd::Constant(xi.size(), 0.5 * std::sqrt(static_cast<double>(xi.size())));
  const Eigen::RowVectorXd mean = outcomes.colwise().mean();
  const Eigen::MatrixXd r = (outcomes.rowwise() - mean).array().rowwise() / mean.array();
  points_.push_back({xi, r.transpose() * r, static_cast<double>(outcomes.rows() - 1)});
}

double Scatter::prediction(const Eigen::VectorXd& widths) const {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(points_.front().squares.rows());
  double all = 0, sum = 0;
  for (const auto& p : points_) {
    mean += p.squares.diagonal();
    all += p.freedom;
  }
  mean /= all;
  for (const auto& p : points_) {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(mean.size());
    double known = 0;
    for (const auto& q : points_) {
      if (&p == &q) continue;
      const double k = weight(p.xi, q.xi, widths);
      w += k * q.squares.diagonal();
      known += k * q.freedom;
    }
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
      if (mean[i] == 0) continue;  // no scatter
      const double here = std::max(known > 0 ? w[i] / known : 0.0, 1e-9 * mean[i]);
      sum -= 0.5 * (p.freedom * std::log(here) + p.squares(i, i) / here);
    }
  }
  return sum;
}

void Scatter::choose_widths() {
  if (points_.size() < 3) return;
  const double whole = 0.5 * std::sqrt(static_cast<double>(widths_.size()));
  double best = prediction(widths_);
  for (int cycle = 0; cycle < 2; ++cycle)
    for (Eigen::Index j = 0; j < widths_.size(); ++j) {
      Eigen::VectorXd widths = widths_;
      for (const double share : shares) {
        widths[j] = share * whole;
        if (const double here = prediction(widths); here > best) {
          best = here;
          widths_ = widths;
        }
      }
    }
}

Scatter::Local Scatter::at(const Eigen::VectorXd& xi) const {
  const auto m = points_.front().squares.rows();
  Local local{Eigen::MatrixXd::Zero(m, m), 0};
  double known = 0, squares = 0;
  for (const auto& p : points_) {
    const double k = weight(xi, p.xi, widths_);
    local.covariance += k * p.squares;
    known += k * p.freedom;
    squares += k * k * p.freedom;
  }
  local.covariance /= known;
  local.freedom = known * known / squares;
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
