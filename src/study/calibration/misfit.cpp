#include "study/calibration/misfit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace freeplay {
namespace {

std::vector<std::size_t> places(const std::vector<bool>& used) {
  std::vector<std::size_t> list;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) list.push_back(i);
  return list;
}

}  // namespace

Misfit::Parts Misfit::parts(std::size_t target, const Eigen::VectorXd& xi) const {
  const auto& t = targets_[target];
  const auto& runs = scatter_[static_cast<std::size_t>(t.runs)];
  const auto of_mean = [&](double scatter) { return scatter * t.stretches.share(scatter); };
  const double surface = t.surface.variance(xi);
  if (!runs.known()) return {of_mean(t.surface.noise()), surface, t.surface.freedom(), t.surface.noise()};
  const auto local = runs.at(xi);
  const double run = local.covariance(t.column, t.column);
  return {of_mean(run), surface, local.freedom, run};
}

double Misfit::freedom(const Eigen::VectorXd& xi, const std::vector<bool>& used) const {
  double fewest = INFINITY;
  for (const auto i : places(used)) {
    const auto p = parts(i, xi);
    const double whole = p.scatter + p.surface + std::pow(targets_[i].tolerance, 2);
    const double doubt =
        std::pow(p.scatter, 2) / p.freedom + std::pow(p.surface, 2) / targets_[i].surface.freedom();
    if (doubt > 1e-9 * whole * whole) fewest = std::min(fewest, whole * whole / doubt);
  }
  return fewest;
}

Misfit::At Misfit::at(const Eigen::VectorXd& xi, const std::vector<bool>& used, const Own* own) const {
  const auto list = places(used);
  const auto m = static_cast<Eigen::Index>(list.size());
  At a{Eigen::VectorXd(m), Eigen::MatrixXd::Zero(m, m), 0, pull * xi.squaredNorm()};
  Eigen::MatrixXd measurement = Eigen::MatrixXd::Zero(m, m);  // U
  std::vector<std::optional<Scatter::Local>> local(scatter_.size());
  Eigen::VectorXd s(m), share(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const auto& t = targets_[list[i]];
    a.residual[i] = t.logarithm - (own ? own->logarithms[static_cast<Eigen::Index>(list[i])] : t.surface(xi));
    auto& w = local[static_cast<std::size_t>(t.runs)];
    const auto& runs = scatter_[static_cast<std::size_t>(t.runs)];
    if (!w && runs.known()) w = runs.at(xi);
    const double scatter = w ? w->covariance(t.column, t.column) : t.surface.noise();
    s[i] =
        std::sqrt(own ? scatter / own->starts[static_cast<Eigen::Index>(list[i])] : t.surface.variance(xi));
    share[i] = t.stretches.share(scatter);
    measurement(i, i) = scatter * share[i] + t.tolerance * t.tolerance;
    a.covariance(i, i) = measurement(i, i) + s[i] * s[i];
    for (Eigen::Index j = 0; j < i; ++j) {
      const auto& u = targets_[list[j]];
      if (u.runs != t.runs || !w) continue;
      const double size = std::sqrt(w->covariance(t.column, t.column) * w->covariance(u.column, u.column));
      if (size == 0) continue;
      const double both = w->covariance(t.column, u.column);
      if (u.source == t.source) measurement(i, j) = measurement(j, i) = both * std::sqrt(share[i] * share[j]);
      a.covariance(i, j) = a.covariance(j, i) = measurement(i, j) + both / size * s[i] * s[j];
    }
  }
  if (m == 0) return a;
  a.squares = a.residual.dot(a.covariance.ldlt().solve(a.residual));
  a.value += a.squares + Eigen::LDLT<Eigen::MatrixXd>(measurement).vectorD().array().max(1e-300).log().sum();
  return a;
}

Eigen::MatrixXd Misfit::jacobian(const Eigen::VectorXd& xi, const std::vector<bool>& used) const {
  const auto list = places(used);
  Eigen::MatrixXd J(static_cast<Eigen::Index>(list.size()), xi.size());
  for (std::size_t i = 0; i < list.size(); ++i)
    J.row(static_cast<Eigen::Index>(i)) = targets_[list[i]].surface.gradient(xi).transpose();
  return J;
}

Identifiability identifiability(const Misfit& misfit, const Eigen::MatrixXd& points) {
  const auto n = points.cols();
  const auto m = static_cast<Eigen::Index>(misfit.targets().size());
  const std::vector<bool> all(misfit.targets().size(), true);
  Identifiability found;
  found.sensitivity = Eigen::MatrixXd::Zero(m, n);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(n, n);
  std::vector<std::vector<double>> widths(static_cast<std::size_t>(n));
  // The surfaces at many places, each of which could be met if the truth were a point of the design.
  const auto places = space_filling(static_cast<int>(n), 256 * static_cast<int>(n));
  Eigen::MatrixXd outcomes(m, places.rows());
  std::vector<Eigen::MatrixXd> precision;
  for (Eigen::Index q = 0; q < places.rows(); ++q) {
    const auto at = misfit.at(places.row(q).transpose(), all);
    for (Eigen::Index i = 0; i < m; ++i)
      outcomes(i, q) = misfit.targets()[static_cast<std::size_t>(i)].logarithm - at.residual[i];
    precision.push_back(at.covariance.ldlt().solve(Eigen::MatrixXd::Identity(m, m)));
  }
  for (Eigen::Index p = 0; p < points.rows(); ++p) {
    const Eigen::VectorXd xi = points.row(p).transpose();
    const auto J = misfit.jacobian(xi, all);
    const auto at = misfit.at(xi, all);
    const auto& V = at.covariance;
    const Eigen::MatrixXd information =
        J.transpose() * V.ldlt().solve(J) + Misfit::pull * Eigen::MatrixXd::Identity(n, n);
    mean += information / static_cast<double>(points.rows());
    found.sensitivity +=
        (V.diagonal().cwiseInverse().asDiagonal() * J.cwiseAbs2()) / static_cast<double>(points.rows());
    const Eigen::MatrixXd covariance = information.inverse();
    Eigen::VectorXd low = xi - 1.96 * covariance.diagonal().cwiseSqrt(),
                    high = xi + 1.96 * covariance.diagonal().cwiseSqrt();
    low = low.cwiseMax(-1);
    high = high.cwiseMin(1);
    Eigen::VectorXd here(m);
    for (Eigen::Index i = 0; i < m; ++i)
      here[i] = misfit.targets()[static_cast<std::size_t>(i)].logarithm - at.residual[i];
    for (Eigen::Index q = 0; q < places.rows(); ++q) {
      const Eigen::VectorXd apart = outcomes.col(q) - here, place = places.row(q).transpose();
      if (apart.dot(precision[static_cast<std::size_t>(q)] * apart) +
              Misfit::pull * (place - xi).squaredNorm() >
          1.96 * 1.96)
        continue;
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    for (Eigen::Index j = 0; j < n; ++j)
      widths[static_cast<std::size_t>(j)].push_back(0.5 * (high[j] - low[j]));
  }
  found.sensitivity = found.sensitivity.cwiseSqrt();
  for (auto& list : widths) {
    std::ranges::nth_element(list, list.begin() + static_cast<std::ptrdiff_t>(list.size() / 2));
    found.left_open.push_back(list[list.size() / 2]);
  }
  const Eigen::MatrixXd covariance = mean.inverse();
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  found.correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  return found;
}

}  // namespace freeplay
