// An upper bound of an output h(u) over all positions u ∈ U within the clearances.
//
// With the adjoint λ at the best u* found, the function y − λᵀ(v − u* w) of q has no first derivative at
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

#include "analysis/play/play_output.hpp"
#include "analysis/play/play_search.hpp"

namespace freeplay {

/// How far h(u) may exceed h(x.u) for any u ∈ U. The last h.evaluate() is that at x.u, and the last enclosed_poses()
/// of the mechanism that of h.region. Infinite if no bound is found.
double excess(PlayOutput& h, const PlayExtreme& x);

}  // namespace freeplay
