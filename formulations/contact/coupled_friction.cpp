#include "formulations/contact/coupled_friction.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>

namespace freeplay {

// Anderson acceleration of the iteration B = Γ(B) for friction bounds (coupled_friction.hpp). With
// the residual r = Γ(B) − B and the differences ΔR, ΔG of successive residuals and images Γ(B),
//
//     B_next = Γ(B) − ΔG s,     s = argmin |r − ΔR s|.

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

CoupledFriction::CoupledFriction(const System& system) : which_(system.reactive_frictions()) {
  for (const int k : which_) bounds_.push_back(*system.friction_facts(k).reaction);
  const auto n = static_cast<Eigen::Index>(which_.size());
  for (auto* x : {&factor_, &near_, &force_, &other_, &trial_, &F_, &step_, &far_, &weight_, &image_})
    x->setZero(n);
  base_.setZero(2 * n);
  R_.setZero(2 * n, n);
  slope_.setIdentity(n, n);
  if (n > 0) lu_.compute(slope_);
}

void CoupledFriction::base(const double* lambda) {
  for (int k = 0; k < size(); ++k) {
    const auto l = bound(k).reactions(lambda);
    for (const int i : {0, 1}) base_[2 * k + i] = l[static_cast<std::size_t>(i)];
  }
}

void CoupledFriction::column(int j, const double* lambda) {
  for (int k = 0; k < size(); ++k) {
    const auto l = bound(k).reactions(lambda);
    for (const int i : {0, 1}) R_(2 * k + i, j) = l[static_cast<std::size_t>(i)];
  }
}

ReactionBound::Reactions CoupledFriction::multipliers(int k, const Eigen::VectorXd& f) const {
  ReactionBound::Reactions l{base_[2 * k], base_[2 * k + 1]};
  for (int j = 0; j < size(); ++j)
    for (const int i : {0, 1}) l[static_cast<std::size_t>(i)] += R_(2 * k + i, j) * f[j];
  return l;
}

double CoupledFriction::support(int k) const { return support(k, multipliers(k, force_)); }

/// Computes F at f and scale_; returns max |F|.
double CoupledFriction::miss(const Eigen::VectorXd& f) {
  double worst = 0;
  scale_ = 0;
  for (int k = 0; k < size(); ++k) {
    const double S = support(k, multipliers(k, f));
    F_[k] = f[k] + factor_[k] * S;
    const double size = std::abs(F_[k]);
    if (!(size <= worst)) worst = std::isnan(size) ? INFINITY : size;
    scale_ = std::max(scale_, std::abs(factor_[k]) * S);
  }
  return worst;
}

bool CoupledFriction::newton(Eigen::VectorXd& f) {
  double left = miss(f);
  for (int i = 0; i < 60; ++i) {
    if (left <= 1e-15 * scale_) return true;
    std::swap(force_, f);  // slopes() evaluates at force_
    slopes();
    std::swap(force_, f);
    lu_.solve(F_, step_);
    double share = 1, next = INFINITY;
    for (int halved = 0; halved < 12; ++halved, share *= 0.5) {
      trial_ = f - share * step_;
      next = miss(trial_);
      if (next < left) break;
    }
    if (!(next < left)) break;  // rounding limit, or no descent
    f.swap(trial_);
    left = next;
  }
  left = miss(f);
  return left <= 1e-11 * scale_;
}

double CoupledFriction::gain() const {
  const int n = size();
  weight_.setOnes();
  double least = INFINITY;
  for (int i = 0; i < 20; ++i) {
    double most = 0;
    for (int k = 0; k < n; ++k) {
      image_[k] = 0;
      for (int j = 0; j < n; ++j)
        image_[k] += std::abs(factor_[k]) * bound(k).change({R_(2 * k, j), R_(2 * k + 1, j)}) * weight_[j];
      most = std::max(most, image_[k] / weight_[k]);  // Collatz and Wielandt: an upper bound
    }
    least = std::min(least, most);
    if (least < 1 || !(most > 0)) break;
    weight_ = 0.5 * (weight_ + image_ / image_.maxCoeff());
  }
  return least;
}

CoupledFriction::Outcome CoupledFriction::solve() {
  const int n = size();
  for (int k = 0; k < n; ++k) force_[k] = -factor_[k] * support(k, {base_[2 * k], base_[2 * k + 1]});
  other_ = force_;
  bool found = newton(other_);
  const bool one = gain() < 1;
  if (!found) {
    other_.setZero();
    found = newton(other_);
  }
  if (found && one) {
    force_ = other_;
    residual_ = scale_ > 0 ? miss(force_) / scale_ : 0;
    return Outcome::solved;
  }
  // Start from a great distance, where S is nearly linear.
  const double far = std::max(1e3 * other_.cwiseAbs().maxCoeff(), 1e-300);
  for (const double by : {1.0, 1e-2}) {
    for (int k = 0; k < n; ++k) far_[k] = -std::copysign(factor_[k] != 0 ? by * far : 0, factor_[k]);
    if (!newton(far_)) continue;
    if (found && (far_ - other_).cwiseAbs().maxCoeff() > 1e-6 * far_.cwiseAbs().maxCoeff())
      return Outcome::several;
    other_ = far_;
    found = true;
  }
  if (!found) return Outcome::none;
  force_ = other_;
  residual_ = miss(force_) / std::max(scale_, 1e-300);
  return Outcome::solved;
}

CoupledFriction::Outcome CoupledFriction::follow_branch() {
  if (gain() < 1) return solve();
  other_ = near_;
  if (!newton(other_)) return solve();
  force_ = other_;
  residual_ = scale_ > 0 ? miss(force_) / scale_ : 0;
  return Outcome::solved;
}

/// Factorises 1 + c S' R at force_ in lu_.
void CoupledFriction::slopes() {
  for (int k = 0; k < size(); ++k) {
    const auto g = bound(k).slope(multipliers(k, force_), -factor_[k]);
    for (int j = 0; j < size(); ++j)
      slope_(k, j) = (k == j) + factor_[k] * (g[0] * R_(2 * k, j) + g[1] * R_(2 * k + 1, j));
  }
  lu_.compute(slope_);
}

void CoupledFriction::prepare_follow() { slopes(); }

void CoupledFriction::follow(const double* dlambda, double* df) {
  for (int k = 0; k < size(); ++k) {
    const auto g = bound(k).slope(multipliers(k, force_), -factor_[k]), d = bound(k).reactions(dlambda);
    step_[k] = -factor_[k] * (g[0] * d[0] + g[1] * d[1]);
  }
  lu_.solve(step_, trial_);
  for (int k = 0; k < size(); ++k) df[k] = trial_[k];
}

const char* words_of(CoupledFriction::Outcome outcome) {
  return outcome == CoupledFriction::Outcome::several
             ? "joint friction admits several motions: the reactions that bound it grow faster than it "
               "does (the mechanism is self-locking)"
             : "joint friction admits no finite reactions: they grow faster than the friction that they "
               "bound (the mechanism is self-locking)";
}

}  // namespace freeplay
