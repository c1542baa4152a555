// CoupledFriction: friction of all joints at one instant, where the reactions that bound the
// friction depend on it,
//
//     f_k = −c_k S_k(λ_k),     λ_k = λ⁰_k + Σ_j R_kj f_j
//
// with the support force S of dynamics/evaluation.hpp, c_k = ±μ(|u_k|) for sliding joints (with
// the sign of u_k; weighted by the regularisation in the penalty formulation), the multipliers λ⁰
// without this friction, and R_kj the multipliers per unit of f_j. The solver is Newton's method on
// F(f) = f + c S(λ⁰ + R f), F' = 1 + c S' R, with halved steps where |F| does not decrease. The
// residual is max |F| over the greatest |c| S.
//
// Number of solutions: S is a norm, or a constant, so f → −c S(λ⁰ + R f) is a contraction, with exactly
// one solution, if the gain, the spectral radius of K_kj = |c_k| S_k(R_kj), is below 1. For one joint
// alone, F is convex on either side. With a gain of 1 or more there are none or two solutions, as
// in Painlevé's paradox; the mechanism is then self-locking. With several joints, other solutions
// are sought from distant starting points.
//
// Usage: set factor(), base() and column() for the present state, call solve() or follow_branch(), read
// force().
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <vector>

#include "dynamics/system.hpp"
#include "numerics/dense.hpp"

namespace freeplay {

/// BoundIteration: fixed-point iteration for friction bounds that depend on the reactions they
/// influence, B = Γ(B). Γ solves the contact problem with fixed bounds B and returns the bounds that
/// its reactions give (dynamics/evaluation.hpp). Anderson acceleration over the last few
/// iterates (D. G. Anderson, J. ACM 12 (1965) 547) gives the next B; in a fixed contact mode this is
/// a secant method on all bounds at once. If the extrapolation is unusable, the next B is Γ(B); if
/// none of the last ten iterations has halved the residual, it is the mean of B and Γ(B). The
/// residual is the greatest |Γ(B) − B| over the greatest entry of B and Γ(B).
///
/// Usage: start(first), then solve the problem with bounds() and pass the result to refine() until
/// it returns false.
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

class CoupledFriction {
 public:
  enum class Outcome { solved, none, several };

  explicit CoupledFriction(const System& system);

  int size() const { return static_cast<int>(force_.size()); }
  /// Index of the k-th joint among the system's friction elements.
  int friction(int k) const { return which_[static_cast<std::size_t>(k)]; }
  /// Whether any bound depends on reactions.
  bool reads_reactions() const { return std::ranges::any_of(bounds_, &ReactionBound::reads_reactions); }

  /// @name Inputs: c, λ⁰ and the columns of R (multipliers of all rows)
  ///@{
  double& factor(int k) { return factor_[k]; }
  void base(const double* lambda);
  void column(int j, const double* lambda);
  ///@}
  /// N, initial estimate of f for follow_branch().
  double& near(int k) { return near_[k]; }
  Outcome solve();
  /// As solve(). If there may be several solutions, the one that Newton's method finds from near() is
  /// taken, if it finds one: the branch of a motion that has been chosen.
  Outcome follow_branch();
  double force(int k) const { return force_[k]; }
  double residual() const { return residual_; }  ///< residual of the last solve()
  /// An upper bound of the spectral radius of K.
  double gain() const;

  /// At the solution: S_k(λ_k). follow() computes the change of f at fixed c for a change `dlambda`
  /// of λ⁰, after prepare_follow().
  double support(int k) const;
  void prepare_follow();
  void follow(const double* dlambda, double* df);

 private:
  bool newton(Eigen::VectorXd& f);
  double miss(const Eigen::VectorXd& f);
  void slopes();
  ReactionBound::Reactions multipliers(int k, const Eigen::VectorXd& f) const;
  /// S_k, for a force opposed to the sign of c_k.
  double support(int k, const ReactionBound::Reactions& l) const { return bound(k).support(l, -factor_[k]); }
  const ReactionBound& bound(int k) const { return bounds_[static_cast<std::size_t>(k)]; }

  std::vector<int> which_;
  std::vector<ReactionBound> bounds_;
  Eigen::VectorXd factor_, base_, near_, force_, other_, trial_, F_, step_, far_;
  Eigen::MatrixXd R_, slope_;
  mutable Eigen::VectorXd weight_, image_;
  DenseLu lu_;
  double residual_ = 0, scale_ = 0;
};

/// Text of an outcome, for a failure message about joints with friction.
const char* words_of(CoupledFriction::Outcome outcome);

}  // namespace freeplay
