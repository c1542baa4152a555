// BandNewton: Newton's method on the projections (projections.hpp) for an island of many contacts,
// started from the given impulses. The Jacobian is factorised as a band matrix, in the order of a
// breadth-first walk over the island (Cuthill and McKee, Proc. 24th ACM Conf. (1969) 157), so that
// the cost along a chain of bodies is linear. It owns the band matrix and its work vectors.
#pragma once

#include <vector>

#include "formulations/contact/sparse_island.hpp"
#include "numerics/band_lu.hpp"

namespace freeplay {

class BandNewton {
 public:
  /// Computes place_ of each row in the order of a walk that starts at the last unknown of a first
  /// walk. Returns the half-bandwidth in rows.
  int order(const SparseIsland& x);
  /// Solves for the impulses. Returns without a solution if the band is too wide.
  SolverSummary solve(SparseIsland& x, double accepted, int most);
  /// Computes the impulses, of either sign, for which the rate of every row vanishes; where rows
  /// depend on each other, the least impulses. Returns false if the band is too wide.
  bool hold(SparseIsland& x);

 private:
  double project(const SparseIsland& x, bool with_derivative, double proximal);

  std::vector<int> unknown_;       // unknown of each row
  std::vector<int> place_, walk_;  // order of rows in the band
  BandLu band_;
  std::vector<double> F_, P_, step_;
};

}  // namespace freeplay
