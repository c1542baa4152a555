#include "formulations/event_driven/active_rows.hpp"

#include <algorithm>
#include <cmath>

#include "numerics/least_squares.hpp"

namespace freeplay {

ActiveRows::ActiveRows(int n, int m, int most) : n_(n), m_(m), rows_(static_cast<std::size_t>(most)) {
  b.setZero(most);
}

/// Few contacts are active at one time: the room for their dense matrices grows with the greatest
/// number so far.
void ActiveRows::make_room(int rows) {
  if (rows <= room_) return;
  constexpr int least = 16;
  room_ = std::min(std::max({rows, 2 * room_, least}), most());
  response_.resize(static_cast<std::size_t>(room_) * static_cast<std::size_t>(n_));
  reaction_.resize(static_cast<std::size_t>(room_) * static_cast<std::size_t>(m_));
  K.conservativeResize(room_, room_);
}

void ActiveRows::put(int r, SaddlePoint& saddle, const SparseRow& row, const SparseRow* beside,
                     double factor) {
  make_room(r + 1);
  rows_[static_cast<std::size_t>(r)] = row;
  saddle.respond(row, beside, factor, response_.data() + static_cast<long>(r) * n_,
                 reaction_.data() + static_cast<long>(r) * m_);
}

int ActiveRows::add(SaddlePoint& saddle, const SparseRow& row, const SparseRow* beside, double factor) {
  put(used_, saddle, row, beside, factor);
  return used_++;
}

void ActiveRows::fill() {
  for (int r = 0; r < used_; ++r)
    for (int s = 0; s < used_; ++s) K(r, s) = row(r).dot(response(s));
}

void ActiveRows::fill_symmetric() {
  for (int r = 0; r < used_; ++r)
    for (int s = 0; s <= r; ++s) K(r, s) = K(s, r) = row(r).dot(response(s));
}

void ActiveRows::solve() {
  if (used_ == 1 && std::abs(K(0, 0)) > 0 && std::isfinite(K(0, 0))) {  // as below
    x.resize(1);
    x[0] = b[0] / K(0, 0);
    dependent_ = false;
    turn_ = K(0, 0) < 0 ? -1 : 1;
    return;
  }
  const auto active = K.topLeftCorner(used_, used_);
  lu_.compute(active);
  dependent_ = !(lu_.pivot_ratio() > 1e-11);
  turn_ = lu_.sign();
  if (dependent_)
    x = MinimumNorm(active, 1e-10).solve(b.head(used_));
  else
    lu_.solve(b.head(used_), x);
}

void ActiveRows::share(const Eigen::VectorXd& weight) {
  const Eigen::VectorXd root = weight.cwiseSqrt();
  const Eigen::MatrixXd weighted = K.topLeftCorner(used_, used_) * root.asDiagonal();
  x = root.asDiagonal() * MinimumNorm(weighted, 1e-10).solve(b.head(used_));
}

/// x = x₀ + √W Q r with the orthonormal kernel Q of K √W, and the least r.
bool ActiveRows::share_within(const Eigen::VectorXd& weight, const Eigen::MatrixXd& C,
                              const Eigen::VectorXd& c) {
  const double unit = std::max(x.cwiseAbs().maxCoeff(), 1e-300), margin = 1e-11;
  Eigen::VectorXd h = -(C * x + c) / unit;
  if (h.maxCoeff() <= 0) return true;
  const Eigen::VectorXd root = weight.cwiseSqrt();
  const Eigen::MatrixXd weighted = K.topLeftCorner(used_, used_) * root.asDiagonal();
  const Eigen::MatrixXd free = root.asDiagonal() * orthogonal_complement(weighted.transpose(), 1e-10);
  if (free.cols() == 0) return false;
  Eigen::MatrixXd G = C * free;
  for (Eigen::Index i = 0; i < G.rows(); ++i) {
    h[i] += margin;
    const double length = G.row(i).norm();
    if (length <= 1e-10 * C.row(i).norm()) {  // no choice of x changes this condition
      if (h[i] > 2 * margin) return false;
      h[i] = -1;
      continue;
    }
    G.row(i) /= length;
    h[i] /= length;
  }
  Eigen::VectorXd r;
  if (!least_distance(G, h, 0.1 * margin, r) || !((G * r - h).minCoeff() > -0.5 * margin)) return false;
  x += unit * (free * r);
  return true;
}

void ActiveRows::apply(double* a, double* lambda) const {
  for (int r = 0; r < used_; ++r) {
    const double force = x[r];
    const double *own = response(r), *reactions = reaction(r);
    for (int i = 0; i < n_; ++i) a[i] += force * own[i];
    for (int k = 0; k < m_; ++k) lambda[k] += force * reactions[k];
  }
}

}  // namespace freeplay
