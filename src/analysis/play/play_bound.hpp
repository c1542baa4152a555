// An upper bound of an output h(u) over a part V of the positions within the clearances.
//
// With the adjoint λ at a position u*, the function p = y − λᵀ(v − u* w) of q has no first derivative at q*, and
// equals y + Σ_k λ_k (u_k − u*_k) w_k wherever F = v − u w = 0. Hence for all u ∈ V, with δu = u − u*,
//
//     h(u) − h(u*) = Σ_k λ_k w_k(q)·δu_k + ½ δqᵀ P δq,
//     δq = S̃ δu,   S̃ ∈ F_q(B; u*)⁻¹ w(B),   P ∈ p″(B; u*).
//
// Linear terms. With a_k = λ_k w_k at u*, a_k = α u*_k + r for |u*_k| = 1 and α ≥ 0, the disc gives
// α u*_k·δu_k ≤ −½ α |δu_k|². An entry r_i δu_i is at most 0 and at most −|r_i| δu_i²/d_i, d_i ≥ |δu_i|, if u*_i is at
// the end of V at which r_i u_i is greatest; otherwise its greatest value counts.
//
// Quadratic terms. In units of d_i, S̃ᵀ P S̃ less the squares of the linear terms is contained in C ± R, and
// ½ Σ σ_i with C + R − diag(σ) ≤ 0, σ ≥ 0, bounds the rest. A second bound has P⁺ in place of P, P ≤ P⁺ without negative
// eigenvalues: it is exact where p is concave along the poses, whatever the error of S̃.
//
// Reach. The gradient of h by u_k at q is λ_k(q) w_k(q) with
//
//     F_q(q; u*)ᵀ (λ(q) − λ) = P δq + Σ_k δu_k λ_k(q) w_k,q.
//
// A greatest position û has û_k farthest along this gradient. Where the gradient cannot vanish in B, û_k is at the
// end of an interval, or on a small arc. The maximum of V is that of this reach, about which B is enclosed again. S̃ᵀ P S̃ is
// smaller than α by the ratio of the clearances to the lengths, so the bound is exact after the first round unless
// a joint has next to no influence.
#pragma once

#include <cmath>

#include "analysis/play/output_function.hpp"
#include "analysis/play/play_part.hpp"
#include "analysis/play/play_search.hpp"

namespace freeplay {

struct PartBound {
  double excess = INFINITY;  ///< h(u) ≤ h(u*) + excess in V; infinite: no bound is found
  PlayPart reach;            ///< contains a greatest position of V
  int worst = 0;             ///< the entry of u that contributes most to the excess
};

/// The bound about x; the last h.evaluate() is that at x.u. Rounds end when the excess is at most `accepted`. `fresh`:
/// the last enclosure of the mechanism is that of h.region.
PartBound bound_on_part(OutputFunction& h, const PlayExtreme& x, const PlayPart& part, double accepted,
                        bool fresh);

}  // namespace freeplay
