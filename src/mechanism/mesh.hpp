// Facts of one flank of a pair of gears, and of a gear on a rack; dynamics/mesh/ has the equations that they stand in, with
// the same symbols.
#pragma once

#include <cmath>

#include "values/vec2.hpp"

namespace freeplay {

struct InvoluteFlank {
  double side = 1;           ///< σ
  double kind = 1;           ///< κ
  double Ri = 0, Rj = 0;     ///< m, signed base radii; their sum is positive
  double rest = 0;           ///< m: b/2 − κ S inv α₀
  double phase = 0;          ///< m, φ₀
  double period = INFINITY;  ///< m, in which a tooth follows another along the line of action

  double sum() const { return Ri + Rj; }
  /// S inv α, m, at the distance a of the centres.
  double involute(double a) const {
    const double S = sum(), L = a > S ? std::sqrt(a * a - S * S) : 0;
    return L - S * std::atan2(L, S);
  }
};

struct RackFlank {
  double side = 1;           ///< σ
  Vec2 axis{1, 0};           ///< A in the second body's frame
  double cosine = 1;         ///< of α
  double sine = 0;           ///< of α
  double base = 0;           ///< m, r_b
  double rest = 0;           ///< m: b/2 − r sin α
  double phase = 0;          ///< m, φ₀
  double period = INFINITY;  ///< m, in which a tooth follows another along the line of action
};

}  // namespace freeplay
