// The least and the greatest value of an output over all positions that clearances permit, at one position of
// the drives, and bounds that it cannot exceed.
//
// Region. Let A = F_q⁻¹ and S = −A F_u at the ideal pose q₀ (u = 0). The set B = {q₀ + S u + A δ: u ∈ U, |δ| ≤ η}
// contains exactly one pose of each u ∈ U on this branch of the assembly if (Krawczyk; Neumaier, Interval Methods for
// Systems of Equations, 1990, ch. 5, in coordinates F_q q)
//
//     |(F_q − v_q(B)) (S u + A δ)| + Σ_k |w_k,q(B) (S u + A δ)| ≤ η     for all u ∈ U and |δ| ≤ η,
//
// with F = v − u w (loose_mechanism.hpp). No other branch has a pose in B, and det F_q does not vanish in it: there
// is no dead centre within the clearances. Where this cannot be shown, the position is refused.
//
// Search. h increases most along its gradient a = ∂h/∂u; on U the linear function a·u is greatest at
// u_k = a_k/|a_k|. Setting u to it repeatedly converges like (clearance/length)ⁿ, unless a joint has next to no
// influence. If it does not converge, or the bound does not confirm the result, Ipopt maximises h on U from
// several starts with exact first and second derivatives.
//
// Bound. With the adjoint λ at the best u* found, the function y − λᵀ(v − u* w) of q has no first derivative at
// q*, and equals y + Σ_k λ_k (u_k − u*_k) w_k wherever F = 0. Hence for all u ∈ U, with
// δq = S δu, S ∈ F_q(B; u*)⁻¹ (c or w(B)),
//
//     h(u) − h(u*) = a·δu + ½ δuᵀ M δu,     M ∈ (S, I)ᵀ p″(B; u*) (S, I),      p = y − λᵀF,
//     a_k·δu_k ≤ −½ α_k |δu_k|² + 2 β_k,
//
// where α = a·u* and β is the part of a across u* for |u*| = 1 (|u|² ≤ 1 gives 2u*·δu ≤ −|δu|²). If M − diag(α)
// is negative semidefinite for all M of the enclosure, nothing exceeds h(u*); otherwise the excess is at most
// 2 Σ σ_k with M − diag(α + σ) ≤ 0. M is smaller than α by the ratio of the clearances to the lengths, so
// the bound is exact unless a joint has next to no influence at first order.
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

#include "analysis/play/loose_mechanism.hpp"

namespace freeplay {

/// The refusal of a position at which no bound can be proved.
inline constexpr const char* no_bound =
    "no bound is found: a dead centre lies within or near the clearances, or they are too large for the proof";

/// The box of all poses at one position of the drives.
struct PlayRegion : LooseMechanism::Poses {
  double t = 0;
  /// w at the ideal pose and the greatest change of it, by component
  Eigen::VectorXd width, width_change;
  std::string refusal;  ///< why there is none; empty: there is one
};

/// One end of the range of an output.
struct PlayExtreme {
  double value = 0;      ///< found
  double bound = 0;      ///< cannot be exceeded
  Eigen::VectorXd u;     ///< where it was found
  Eigen::VectorXd q;     ///< the pose
  Eigen::VectorXd a;     ///< gradient of the output by u
  bool settled = false;  ///< whether the search converged
};

class PlayExtremes {
  class Maximum;  // Ipopt's view of h

 public:
  explicit PlayExtremes(LooseMechanism& mechanism) : mechanism_(mechanism) {}

  /// Encloses all poses about the ideal pose q at time t.
  const PlayRegion& enclose(const Eigen::VectorXd& q, double t);
  /// The gradient of output k by u at u = 0, and its value there.
  double ideal(int k, Eigen::VectorXd& a);
  /// The greatest value of sign · output k, and its bound; needs enclose() with success. `start`: where the
  /// search begins (empty: from the ideal pose).
  /// The value of output k at u; empty if the mechanism does not close there.
  std::optional<double> value(int k, const Eigen::VectorXd& u);
  PlayExtreme greatest(int k, double sign, const Eigen::VectorXd& start = {});

 private:
  /// Value of sign · y at u, from the pose q, with its gradient.
  bool at(int k, double sign, const Eigen::VectorXd& u, Eigen::VectorXd& q, double& value,
          Eigen::VectorXd& a);
  void ascend(int k, double sign, PlayExtreme& x);
  /// The bound of x; sets λ.
  void bound(int k, double sign, PlayExtreme& x);
  /// Greatest size of (row ± radius)(S u + A δ) over u ∈ U and |δ| ≤ η.
  double spread(const Eigen::RowVectorXd& row, const Eigen::RowVectorXd& radius, const Eigen::MatrixXd& A,
                const Eigen::VectorXd& eta) const;
  /// A⁻¹ by the last factors.
  Eigen::MatrixXd inverse() const;
  /// The best of local maxima from several starts; `best` is the first one.
  void search(int k, double sign, PlayExtreme& best);
  double excess(int k, double sign, const PlayExtreme& x);
  /// ∂²h/∂u² at the last at().
  Eigen::MatrixXd second_by_u(int k, double sign, const Eigen::VectorXd& u);
  /// The u ∈ U at which a·u is greatest; entries without influence keep their values.
  void vertex(const Eigen::VectorXd& a, Eigen::VectorXd& u) const;

  LooseMechanism& mechanism_;
  PlayRegion region_;
  LooseMechanism::Equations f_;
  LooseMechanism::Enclosures box_;
  DenseLu factors_;
  Eigen::VectorXd lambda_, gradient_;
  Eigen::MatrixXd second_, second_radius_;
};

}  // namespace freeplay
