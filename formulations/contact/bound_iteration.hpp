// BoundIteration: fixed-point iteration for friction bounds that depend on the reactions they
// influence, B = Γ(B). Γ solves the contact problem with fixed bounds B and returns the bounds that
// its reactions give (dynamics/reaction_bound.hpp). Anderson acceleration over the last few
// iterates (D. G. Anderson, J. ACM 12 (1965) 547) gives the next B; in a fixed contact mode this is
// a secant method on all bounds at once. If the extrapolation is unusable, the next B is Γ(B); if
// none of the last ten iterations has halved the residual, it is the mean of B and Γ(B). The
// residual is the greatest |Γ(B) − B| over the greatest entry of B and Γ(B).
//
// Usage: start(first), then solve the problem with bounds() and pass the result to refine() until
// it returns false.
#pragma once

#include <Eigen/Core>

namespace freeplay {

class BoundIteration {
 public:
  static constexpr int most = 200, depth = 5;
  /// number of bounds; more are extrapolated with heap memory
  static constexpr int without_heap = 64;
  /// residual accepted if rounding or the solver's tolerance allows no smaller one
  static constexpr double accepted = 1e-9;

  void start(const Eigen::VectorXd& first);
  const Eigen::VectorXd& bounds() const { return bounds_; }
  double residual() const { return residual_; }
  bool met() const { return residual_ <= accepted; }
  int count() const { return count_; }

  /// Takes Γ of the present bounds. Returns true if there are new bounds to try; otherwise the
  /// present bounds are the result.
  bool refine(const Eigen::VectorXd& image);

 private:
  /// Computes next_, for at most this many bounds and differences.
  template <int rows, int columns>
  void extrapolate(const Eigen::VectorXd& image);

  Eigen::VectorXd bounds_, r_, next_;
  Eigen::MatrixXd R_, G_;  // residuals and images of the last iterates, the latest last
  int kept_ = 0, count_ = 0, stalled_ = 0;
  double best_ = 0, residual_ = 0;
};

}  // namespace freeplay
