// Piles of discs: part of the claim set "complementarity".
#pragma once

#include "verification/claims/claim.hpp"

namespace freeplay::verification {

/// Adds the claims on a stack in a channel, a pyramid and random piles, by both nonsmooth schemes.
void piles(Findings& f);

}  // namespace freeplay::verification
