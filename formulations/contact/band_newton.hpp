// Newton's method for an island of many contacts (projections.hpp), from the impulses given, with band factors in the order
// of a breadth-first walk over the island (Cuthill and McKee, Proc. 24th ACM Conf. (1969) 157): along a chain its cost is linear.
#pragma once

#include <vector>

#include "formulations/contact/sparse_island.hpp"
#include "numerics/band_lu.hpp"

namespace freeplay {

class BandNewton {
 public:
  /// place_ of each row in the order of the walk, begun at the end of another; the half-bandwidth in rows.
  int order(const SparseIsland& x);
  /// Not solved where the band is wide.
  SolverSummary solve(SparseIsland& x, double accepted, int most);
  /// The impulses, of either sign, by which every row's rate vanishes; where rows depend on each other the least. False where
  /// the band is wide.
  bool hold(SparseIsland& x);

 private:
  double project(const SparseIsland& x, bool with_derivative, double proximal);

  std::vector<int> unknown_;       // of each row
  std::vector<int> place_, walk_;  // order of rows in the band
  BandLu band_;
  std::vector<double> F_, P_, step_;
};

}  // namespace freeplay
