#include "formulations/event_driven/active_rows.hpp"

#include <algorithm>
#include <cmath>

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

void ActiveRows::apply(double* a, double* lambda) const {
  for (int r = 0; r < used_; ++r) {
    const double force = x[r];
    const double *own = response(r), *reactions = reaction(r);
    for (int i = 0; i < n_; ++i) a[i] += force * own[i];
    for (int k = 0; k < m_; ++k) lambda[k] += force * reactions[k];
  }
}

}  // namespace freeplay
