// Which rows of a sparse matrix are independent.
#pragma once

#include <span>
#include <vector>

#include "numerics/sparse.hpp"

namespace freeplay {

/// Indices (ascending) of a largest set of independent rows of G M^(−1/2) with its rows scaled to length one,
/// by rank-revealing sparse QR; a row counts as dependent when it lies closer than `tolerance` to the others'
/// span.
std::vector<int> independent_rows(const CsrPattern& G, std::span<const double> values,
                                  std::span<const double> mass, double tolerance = 1e-9);

}  // namespace freeplay
