// Gauss–Seidel over the contacts of an island with D by rows (sparse_island.hpp), from the given
// impulses.
#pragma once

#include "formulations/contact/sparse_island.hpp"

namespace freeplay {

/// `rates`: work space for the rates of the rows.
SolverSummary sparse_sweeps(SparseIsland& x, double accepted, std::vector<double>& rates, int most);

}  // namespace freeplay
