// Facts of one tooth flank: of a pair of gears, and of a gear on a rack. The equations with the
// same symbols are in dynamics/mesh/.
#pragma once

#include <cmath>

#include "values/vec2.hpp"

namespace freeplay {

/// One flank of a pair of gears.
struct InvoluteFlank {
  double side = 1;           ///< σ
  double kind = 1;           ///< κ
  double Ri = 0, Rj = 0;     ///< m, signed base radii; their sum is positive
  double rest = 0;           ///< m, b/2 − κ S inv α₀
  double phase = 0;          ///< m, φ₀
  double period = INFINITY;  ///< m, pitch of the teeth along the line of action

  /// m, sum of the base radii
  double sum() const { return Ri + Rj; }
  /// S inv α (m) at the centre distance a (m).
  double involute(double a) const {
    const double S = sum(), L = a > S ? std::sqrt(a * a - S * S) : 0;
    return L - S * std::atan2(L, S);
  }
};

/// One flank of a gear on a rack.
struct RackFlank {
  double side = 1;           ///< σ
  Vec2 axis{1, 0};           ///< A, in the second body's frame
  double cosine = 1;         ///< cos α
  double sine = 0;           ///< sin α
  double base = 0;           ///< m, r_b
  double rest = 0;           ///< m, b/2 − r sin α
  double phase = 0;          ///< m, φ₀
  double period = INFINITY;  ///< m, pitch of the teeth along the line of action
};

}  // namespace freeplay
