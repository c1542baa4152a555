// Independent rows of a sparse matrix.
#pragma once

#include <span>
#include <vector>

#include "numerics/sparse.hpp"

namespace freeplay {

/// Indices (ascending) of a largest set of independent rows of G M^(−1/2), with each row scaled to
/// unit length, by rank-revealing sparse QR. A row is dependent if its distance from the span of
/// the others is less than `tolerance`.
std::vector<int> independent_rows(const CsrPattern& G, std::span<const double> values,
                                  std::span<const double> mass, double tolerance = 1e-9);

}  // namespace freeplay
