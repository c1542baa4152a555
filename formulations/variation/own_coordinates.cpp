#include "formulations/variation/own_coordinates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/assembly/projection.hpp"
#include "dynamics/system.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "mechanism/scene.hpp"
#include "values/state.hpp"

namespace freeplay {
namespace {

/// Directions of constraint rows closer than this to the span of others are dependent.
constexpr double dependent_constraints = 1e-9;

}  // namespace

OwnCoordinates::OwnCoordinates(const Scene& scene, const System& system, const State& start)
    : system_(system) {
  const double time = make_scales(scene.mechanism, system, start).time;
  if (time > 0 && std::isfinite(time)) time_ = time;
}

Eigen::MatrixXd OwnCoordinates::motions(const Vector& x, double t) const {
  const int n = system_.n();
  if (system_.rows() == 0) return Eigen::MatrixXd::Identity(n, n);
  State s{t, {x.begin(), x.begin() + n}, {x.begin() + n, x.begin() + 2 * n}, {}};
  Eigen::MatrixXd rows = weighted_rows(system_, {}, s);
  for (Eigen::Index k = 0; k < rows.cols(); ++k)
    if (const double size = rows.col(k).norm(); size > 0) rows.col(k) /= size;
  return orthogonal_complement(rows, dependent_constraints);
}

Eigen::VectorXd OwnCoordinates::of(const Eigen::MatrixXd& Z, const Vector& column, int states) const {
  const Eigen::Index n = system_.n(), f = Z.cols();
  Eigen::VectorXd dq(n), dv(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double root = std::sqrt(system_.mass()[static_cast<std::size_t>(i)]);
    dq[i] = root * column[static_cast<std::size_t>(i)];
    dv[i] = root * column[static_cast<std::size_t>(n + i)];
  }
  Eigen::VectorXd u(2 * f + system_.states());
  u.head(f) = Z.transpose() * dq;
  u.segment(f, f) = time_ * (Z.transpose() * dv);
  for (int k = 0; k < system_.states(); ++k)
    u[2 * f + k] =
        column[static_cast<std::size_t>(states) + static_cast<std::size_t>(k)] / system_.state_scale(k);
  return u;
}

Eigen::MatrixXd OwnCoordinates::of(const Eigen::MatrixXd& Z, const std::vector<Vector>& columns,
                                   int states) const {
  Eigen::MatrixXd all(2 * Z.cols() + system_.states(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j)
    all.col(static_cast<Eigen::Index>(j)) = of(Z, columns[j], states);
  return all;
}

std::vector<OwnCoordinates::Vector> OwnCoordinates::basis(const Eigen::MatrixXd& Z) const {
  const auto n = static_cast<std::size_t>(system_.n()), states = static_cast<std::size_t>(system_.states());
  std::vector<Vector> list;
  for (const bool rate : {false, true})
    for (Eigen::Index j = 0; j < Z.cols(); ++j) {
      auto& column = list.emplace_back(2 * n + states);
      for (std::size_t i = 0; i < n; ++i)
        column[(rate ? n : 0) + i] =
            Z(static_cast<Eigen::Index>(i), j) / std::sqrt(system_.mass()[i]) / (rate ? time_ : 1);
    }
  for (std::size_t k = 0; k < states; ++k) {
    auto& column = list.emplace_back(2 * n + states);
    column[2 * n + k] = system_.state_scale(static_cast<int>(k));
  }
  return list;
}

std::vector<double> OwnCoordinates::orthonormalise(std::vector<Vector>& S, const Basis& b) const {
  std::vector<Eigen::VectorXd> u(S.size());
  std::vector<double> logs(S.size(), -INFINITY);
  for (std::size_t j = 0; j < S.size(); ++j) {
    if (!b.collapsed[j].empty()) continue;
    u[j] = of(b.Z, S[j], b.states);
    const double before = u[j].norm();
    for (int pass = 0; pass < 2; ++pass)
      for (std::size_t i = 0; i < j; ++i) {
        if (!b.collapsed[i].empty()) continue;
        const double part = u[i].dot(u[j]);
        u[j] -= part * u[i];
        for (std::size_t k = 0; k < S[j].size(); ++k) S[j][k] -= part * S[i][k];
      }
    const double length = u[j].norm();
    if (!(length > collapsed_share * std::max(1.0, before))) {
      b.collapsed[j] = fmt::format(
          "a perturbation vanishes in finite time, t = {:.9g} s: a lasting contact, sticking or an impact "
          "without rebound",
          b.t);
      b.on_collapse(j);
      continue;
    }
    u[j] /= length;
    for (double& part : S[j]) part /= length;
    logs[j] = std::log(length);
  }
  return logs;
}

}  // namespace freeplay
