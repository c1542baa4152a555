// PlayRegion: a box that contains all poses within the clearances, at one position of the drives.
//
// Let A = F_q⁻¹ and S = −A F_u at the ideal pose q₀ (u = 0). The set B = {q₀ + S u + A δ: u ∈ U, |δ| ≤ η} contains
// exactly one pose of each u ∈ U on this branch of the assembly if (Krawczyk; Neumaier, Interval Methods for
// Systems of Equations, 1990, ch. 5, in coordinates F_q q)
//
//     |(F_q − v_q(B)) (S u + A δ)| + Σ_k |w_k,q(B) (S u + A δ)| ≤ η     for all u ∈ U and |δ| ≤ η,
//
// with F = v − u w (loose_mechanism.hpp). No other branch has a pose in B, and det F_q does not vanish in it: there
// is no dead centre within the clearances. Where this cannot be shown, the position is refused.
#pragma once

#include <Eigen/Core>

#include <string>

#include "analysis/play/loose_mechanism.hpp"

namespace freeplay {

/// The refusal of a position at which no bound can be proved.
inline constexpr const char* no_bound =
    "no bound is found: a dead centre lies within or near the clearances, or they are too large for the proof";

struct PlayRegion : LooseMechanism::Poses {
  double t = 0;
  /// w at the ideal pose and the greatest change of it, by component
  Eigen::VectorXd width, width_change;
  LooseMechanism::Enclosures derivatives;  ///< over B
  std::string refusal;                     ///< why there is none; empty: there is one
};

/// Encloses all poses about the ideal pose q at time t. The mechanism keeps the box for its second derivatives.
PlayRegion enclosed_poses(LooseMechanism& mechanism, const Eigen::VectorXd& q, double t);

}  // namespace freeplay
