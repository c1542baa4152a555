// Gauss–Seidel over the contacts of an island with D by rows (sparse_island.hpp), from the impulses given.
#pragma once

#include "formulations/contact/sparse_island.hpp"

namespace freeplay {

/// `rates`: room for those of the rows.
SolverSummary sparse_sweeps(SparseIsland& x, double accepted, std::vector<double>& rates, int most);

}  // namespace freeplay
