#include "study/calibration/series_estimate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "numerics/quantiles.hpp"
#include "study/calibration/surface.hpp"

namespace freeplay {
namespace {

using Index = Eigen::Index;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr double difference = 4e-3;  // of ξ, to either side
constexpr int most_iterations = 40;

double squares_of(const SeriesResiduals& r) {
  if (r.empty()) return INFINITY;
  double sum = 0;
  for (const auto& series : r) sum += series.squaredNorm();
  return std::isfinite(sum) ? sum : INFINITY;
}

/// Residuals with their derivatives.
struct Linearised {
  SeriesResiduals r;
  std::vector<Matrix> J;
  Matrix H;  // ΣJᵀJ
  Vector g;  // ΣJᵀr
};

Linearised linearised(const ResidualsAt& at, const Vector& xi, const SeriesResiduals& here) {
  const Index n = xi.size();
  std::vector<Vector> points;
  for (Index j = 0; j < n; ++j)
    for (const int side : {-1, 1}) {
      points.push_back(xi);
      points.back()[j] = std::clamp(xi[j] + side * difference, -1.0, 1.0);
    }
  const auto r = at(points);
  Linearised x{here, {}, Matrix::Zero(n, n), Vector::Zero(n)};
  for (std::size_t s = 0; s < here.size(); ++s) {
    Matrix J(here[s].size(), n);
    for (Index j = 0; j < n; ++j) {
      auto k = static_cast<std::size_t>(2 * j);
      // A side whose run failed is replaced by the point itself.
      const auto& below = r[k].empty() ? here[s] : r[k][s];
      const auto& above = r[k + 1].empty() ? here[s] : r[k + 1][s];
      const double low = r[k].empty() ? xi[j] : points[k][j],
                   high = r[k + 1].empty() ? xi[j] : points[k + 1][j];
      if (high > low)
        J.col(j) = (above - below) / (high - low);
      else
        J.col(j).setZero();
    }
    x.H += J.transpose() * J;
    x.g += J.transpose() * here[s];
    x.J.push_back(std::move(J));
  }
  return x;
}

/// (H + λ diag H)⁻¹ g of the unknowns that are not held at a bound; 0 for the others.
Vector step_of(const Linearised& x, const Vector& xi, double damping) {
  std::vector<Index> free;
  for (Index j = 0; j < xi.size(); ++j)
    if (x.H(j, j) > 0 && !(std::abs(xi[j]) >= 1 && x.g[j] * xi[j] < 0)) free.push_back(j);
  Vector step = Vector::Zero(xi.size());
  if (free.empty()) return step;
  Matrix H = x.H(free, free);
  H.diagonal() *= 1 + damping;
  const Vector g = x.g(free);
  step(free) = -H.ldlt().solve(g);
  return step;
}

/// V, and the number of independent samples.
Matrix covariance_of(const Linearised& x, double& independent) {
  const Index n = x.g.size();
  Matrix M = Matrix::Zero(n, n);
  double squares = 0, count = 0;
  independent = 0;
  for (std::size_t s = 0; s < x.r.size(); ++s) {
    const auto c = autocovariance(x.r[s]);
    const Index samples = x.r[s].size();
    for (std::size_t k = 0; k < c.size(); ++k) {
      const auto lag = static_cast<Index>(k);
      const Matrix G = x.J[s].topRows(samples - lag).transpose() * x.J[s].bottomRows(samples - lag);
      M += k == 0 ? Matrix(c[k] * G) : Matrix(c[k] * (G + G.transpose()));
    }
    independent += static_cast<double>(samples) / correlation_samples(c);
    squares += x.r[s].squaredNorm();
    count += static_cast<double>(samples);
  }
  Matrix H = x.H;
  for (Index j = 0; j < n; ++j)  // an unknown without influence has a wide interval
    if (!(H(j, j) > 0)) H(j, j) = 1e-12 * std::max(1.0, squares);
  const Matrix A = H.ldlt().solve(Matrix::Identity(n, n));
  const double correction = count / std::max(1.0, count - static_cast<double>(n));
  Matrix V = correction * A * M * A;
  for (Index j = 0; j < n; ++j) {
    const double white = correction * squares / count * A(j, j);
    if (V(j, j) >= white) continue;
    const double factor = V(j, j) > 0 ? std::sqrt(white / V(j, j)) : 0;
    V.row(j) *= factor;
    V.col(j) *= factor;
    V(j, j) = white;
  }
  return V;
}

}  // namespace

std::vector<double> autocovariance(const Eigen::VectorXd& residual) {
  const Index n = residual.size();
  const auto at = [&](Index lag) {
    return lag < n ? residual.head(n - lag).dot(residual.tail(n - lag)) / static_cast<double>(n) : 0.0;
  };
  std::vector<double> c{at(0)};
  for (Index lag = 1; lag + 1 < n; lag += 2) {
    const double a = at(lag), b = at(lag + 1);
    if (!(a + b > 0)) break;
    c.push_back(a);
    c.push_back(b);
  }
  return c;
}

double correlation_samples(const std::vector<double>& c) {
  double sum = 0;
  for (std::size_t k = 1; k < c.size(); ++k) sum += c[k];
  return c[0] > 0 ? std::max(1.0, 1 + 2 * sum / c[0]) : 1;
}

SeriesEstimate estimate_series(const ResidualsAt& at, int unknowns) {
  const auto n = static_cast<Index>(unknowns);
  std::vector<Vector> points{Vector::Zero(n)};
  const auto design = space_filling(unknowns, 8 * unknowns);
  for (const auto row : design.rowwise()) points.emplace_back(row.transpose());
  auto tried = at(points);
  const auto best_of = [](const std::vector<SeriesResiduals>& list) {
    return static_cast<std::size_t>(std::ranges::min_element(list, {}, squares_of) - list.begin());
  };
  auto best = best_of(tried);
  SeriesEstimate e;
  e.squares = squares_of(tried[best]);
  if (!std::isfinite(e.squares))
    throw std::runtime_error("calibration: no run within the ranges of the unknowns gives the series");
  e.xi = points[best];
  SeriesResiduals here = std::move(tried[best]);
  double damping = 1e-2;
  for (bool better = true;; ++e.iterations) {
    const auto x = linearised(at, e.xi, here);
    e.covariance = covariance_of(x, e.independent);
    const Vector step = step_of(x, e.xi, 0);
    const double far = (step.array().abs() / e.covariance.diagonal().array().sqrt().max(1e-300)).maxCoeff();
    e.converged = far < 0.1;
    if (far < 0.01 || !better || e.iterations == most_iterations) break;
    better = false;
    for (int round = 0; round < 3 && !better; ++round) {
      points.clear();
      std::vector<double> dampings;
      for (const double factor : {0.0, 0.1, 1.0, 10.0}) {
        dampings.push_back(factor * damping);
        points.push_back((e.xi + step_of(x, e.xi, dampings.back())).cwiseMax(-1).cwiseMin(1));
      }
      tried = at(points);
      best = best_of(tried);
      better = squares_of(tried[best]) < e.squares;
      damping = better ? std::clamp(dampings[best], 1e-6, 1e6) : 100 * damping;
    }
    if (!better) continue;  // evaluates once more, and ends
    e.xi = points[best];
    e.squares = squares_of(tried[best]);
    here = std::move(tried[best]);
  }
  const double freedom = e.independent - unknowns;
  e.quantile = freedom >= 1 ? student_quantile(freedom, 0.975) : NAN;
  return e;
}

}  // namespace freeplay
