// Friction that is bounded by reactions which it changes itself, of all joints with friction at one instant:
//
//     f_k = −c_k S_k(λ_k),     λ_k = λ⁰_k + Σ_j R_kj f_j
//
// with S of dynamics/reaction_bound.hpp, c_k = ±μ(|u_k|) of what slides (its sign that of u_k; in the penalty formulation
// weighed by the regularisation), λ⁰ the multipliers without this friction and R_kj those that a unit of f_j adds. Solved
// by Newton's method on F(f) = f + c S(λ⁰ + R f), F' = 1 + c S' R, with halved steps where |F| does not fall. Judged by
// max |F| over the greatest |c| S.
//
// How many solutions there are: S is a norm, so f → −c S(λ⁰ + R f) shrinks distances where the spectral radius of
// K_kj = |c_k| S_k(R_kj), the gain, is below 1, and there is exactly one. Of one joint alone F is convex on either side:
// with a gain of 1 or more there are none or two, as in Painlevé's paradox; the mechanism is then self-locking. With
// several joints other solutions are looked for from far off.
#pragma once

#include <vector>

#include "dynamics/system.hpp"
#include "numerics/dense.hpp"

namespace freeplay {

class CoupledFriction {
 public:
  enum class Outcome { solved, none, several };

  explicit CoupledFriction(const System& system);

  int size() const { return static_cast<int>(force_.size()); }
  /// Index of the k-th among the system's frictions.
  int friction(int k) const { return which_[static_cast<std::size_t>(k)]; }

  /// @name What varies: c, λ⁰ and the columns of R (multipliers of all rows)
  ///@{
  double& factor(int k) { return factor_[k]; }
  void base(const double* lambda);
  void column(int j, const double* lambda);
  ///@}
  Outcome solve();
  double force(int k) const { return force_[k]; }
  double residual() const { return residual_; }  ///< of the last solve()
  /// An upper bound of the spectral radius of K.
  double gain() const;

  /// At the solution: S_k(λ_k), and with `dlambda` the change of λ⁰ the change of f that follows it at fixed c.
  double support(int k) const;
  void prepare_follow();
  void follow(const double* dlambda, double* df);

 private:
  bool newton(Eigen::VectorXd& f);
  double miss(const Eigen::VectorXd& f);
  void slopes();
  std::array<double, 2> multipliers(int k, const Eigen::VectorXd& f) const;
  const ReactionBound& bound(int k) const { return bounds_[static_cast<std::size_t>(k)]; }

  std::vector<int> which_;
  std::vector<ReactionBound> bounds_;
  Eigen::VectorXd factor_, base_, force_, other_, trial_, F_, step_, far_;
  Eigen::MatrixXd R_, slope_;
  mutable Eigen::VectorXd weight_, image_;
  DenseLu lu_;
  double residual_ = 0, scale_ = 0;
};

/// In words, for a failure: of the joints with friction.
const char* words_of(CoupledFriction::Outcome outcome);

}  // namespace freeplay
