// Piles of discs: part of the claim set "complementarity".
#pragma once

#include "verification/claims/claim.hpp"

namespace freeplay::verification {

/// A stack in a channel and a pyramid against their weights, and random piles by both nonsmooth schemes.
void piles(Findings& f);

}  // namespace freeplay::verification
