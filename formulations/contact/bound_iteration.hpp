// Bounds of friction that follow from what they lead to: B = Γ(B), Γ the problem with fixed bounds solved, then the bounds
// that its reactions give (dynamics/reaction_bound.hpp). Each B is followed by Γ(B) extrapolated over the last few
// (D. G. Anderson, J. ACM 12 (1965) 547), which in a fixed mode is a secant method on all bounds at once; where that
// leads nowhere, by Γ(B) itself, and by the middle of the two where nothing comes nearer for ten tries. Judged by max |Γ(B) − B| over max Γ(B).
#pragma once

#include <Eigen/Core>

namespace freeplay {

class BoundIteration {
 public:
  static constexpr int most = 200, depth = 5;
  static constexpr int without_heap = 64;   ///< bounds; more are extrapolated with memory of their own
  static constexpr double accepted = 1e-9;  ///< where rounding, or the solver's tolerance, leaves no less

  void start(const Eigen::VectorXd& first);
  const Eigen::VectorXd& bounds() const { return bounds_; }
  double residual() const { return residual_; }
  bool met() const { return residual_ <= accepted; }
  int count() const { return count_; }

  /// Takes Γ of the present bounds. True when there are others to try; else the present ones stand.
  bool refine(const Eigen::VectorXd& image);

 private:
  /// next_, for at most so many bounds and differences.
  template <int rows, int columns>
  void extrapolate(const Eigen::VectorXd& image);

  Eigen::VectorXd bounds_, r_, next_;
  Eigen::MatrixXd R_, G_;  // residuals and images of the last few, the latest behind
  int kept_ = 0, count_ = 0, stalled_ = 0;
  double best_ = 0, residual_ = 0;
};

}  // namespace freeplay
