// Anderson acceleration of the iteration B = Γ(B) for friction bounds (bound_iteration.hpp). With
// the residual r = Γ(B) − B and the differences ΔR, ΔG of successive residuals and images Γ(B),
//
//     B_next = Γ(B) − ΔG s,     s = argmin |r − ΔR s|.
#include "formulations/contact/bound_iteration.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace freeplay {

template <int rows, int columns>
void BoundIteration::extrapolate(const Eigen::VectorXd& image) {
  using Differences = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, rows, columns>;
  using Bounds = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, rows, 1>;
  using Shares = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, columns, 1>;
  const auto n = image.size();
  const auto m = std::min<Eigen::Index>(kept_ - 1, n);
  Differences dR(n, m), dG(n, m);
  for (int i = 0; i < m; ++i) {
    dR.col(i) = R_.col(kept_ - 1 - i) - R_.col(kept_ - 2 - i);
    dG.col(i) = G_.col(kept_ - 1 - i) - G_.col(kept_ - 2 - i);
  }
  const Bounds r = r_;
  const Shares shares = dR.colPivHouseholderQr().solve(r);
  const Bounds by = dG * shares;
  next_ = image - by;
}

void BoundIteration::start(const Eigen::VectorXd& first) {
  bounds_ = first;
  if (const auto n = first.size(); R_.rows() != n) {
    R_.resize(n, depth + 1);
    G_.resize(n, depth + 1);
    r_.resize(n);
    next_.resize(n);
  }
  kept_ = count_ = stalled_ = 0;
  best_ = residual_ = INFINITY;
}
bool BoundIteration::refine(const Eigen::VectorXd& image) {
  r_ = image - bounds_;
  const double size = std::max(image.cwiseAbs().maxCoeff(), bounds_.cwiseAbs().maxCoeff());
  residual_ = size > 0 ? r_.cwiseAbs().maxCoeff() / size : 0;
  if (!(residual_ > 1e-14)) {
    if (std::isnan(residual_)) residual_ = INFINITY;
    return false;
  }
  stalled_ = residual_ < 0.5 * best_ ? 0 : stalled_ + 1;
  if (++count_ >= most || (residual_ <= 1e-12 && stalled_ > 1) || (met() && stalled_ > 6)) return false;
  best_ = std::min(best_, residual_);
  if (stalled_ > 10 && !met()) {  // restart at the mean of B and Γ(B), without history
    kept_ = stalled_ = 0;
    bounds_ = 0.5 * (bounds_ + image);
    return true;
  }
  if (kept_ == depth + 1) {
    for (int i = 0; i < depth; ++i) {
      R_.col(i) = R_.col(i + 1);
      G_.col(i) = G_.col(i + 1);
    }
    --kept_;
  }
  R_.col(kept_) = r_;
  G_.col(kept_) = image;
  ++kept_;
  bounds_ = image;
  if (kept_ > 1) {
    if (image.size() <= without_heap)
      extrapolate<without_heap, depth>(image);
    else
      extrapolate<Eigen::Dynamic, Eigen::Dynamic>(image);
    if (next_.allFinite() && next_.minCoeff() >= 0 && next_.maxCoeff() <= 1e3 * size) bounds_ = next_;
  }
  return true;
}

}  // namespace freeplay
