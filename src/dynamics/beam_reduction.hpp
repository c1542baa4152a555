// Reduction of a beam by Craig and Bampton, AIAA Journal 6 (1968) 1313. With the transverse displacements and the
// rotations u of the pieces of the full beam over its chord, and the rotations φ of its ends there,
//
//     u = S φ + Ψ η,      S = −K⁻¹ K_φ,      K Ψ = M Ψ Ω²,  Ψᵀ M Ψ = 1,
//
// where K and K_φ belong to the beam elements for small deflections and M has the masses and moments of inertia of the
// pieces. S is the static deflection by rotations of the ends, Ψ has the lowest modes of the beam clamped at both ends.
// The strain energy is that of one element from end to end, by φ, and ½ ηᵀ Ω² η. The amplitudes follow from the
// displacements y of the pieces without their static part: η = P y, P = (Ψ_yᵀ Ψ_y)⁻¹ Ψ_yᵀ.
#pragma once

#include <Eigen/Core>

namespace freeplay {

struct Beam;

struct BeamReduction {
  /// Throws ModelError if displacements do not determine the amplitudes.
  explicit BeamReduction(const Beam& beam);

  Eigen::MatrixXd deflection, rotation;  ///< S: m/rad and rad/rad, a row for each piece
  Eigen::MatrixXd shapes, turns;         ///< Ψ: 1/√kg and 1/(m √kg), a column for each mode
  Eigen::VectorXd frequency;             ///< Ω, rad/s
  Eigen::MatrixXd amplitudes;            ///< P, √kg
  Eigen::MatrixXd others;                ///< orthonormal columns C; Cᵀ y = 0 has no other modes
};

}  // namespace freeplay
