// Allocation of clearances: those of least cost with which the width of an output stays below a target at all
// positions,
//
//     min Σ_k b_k x_k^(−p_k)    subject to    width_i(x) ≤ target,    least_k ≤ c_k ≤ greatest_k,     x_k = c_k/c_k0,
//
// with the reciprocal power model of cost (Sutherland and Roth, J. Eng. Ind. 97 (1975) 283): b_k is the cost of
// joint k at the clearance c_k0 of the scene. The widths are nearly sums of parts that are proportional to the
// clearances (play.hpp). With the parts of the present clearances the problem is convex; Ipopt solves it, the
// parts are computed again, and so on until the clearances do not change.
#pragma once

#include <string>
#include <vector>

#include "analysis/play/play.hpp"

namespace freeplay {

/// Cost of the clearance of one joint.
struct ClearanceCost {
  std::string joint;
  double cost = 1, exponent = 1;   ///< b_k, p_k > 0
  double least = 0, greatest = 0;  ///< m, 0 < least ≤ greatest
};

struct AllocatedClearance {
  std::string joint;
  double before = 0, after = 0;  ///< m
  double cost = 0;               ///< with `after`
  enum class Limit { none, least, greatest } limit = Limit::none;
};

struct Allocation {
  std::vector<AllocatedClearance> clearances;
  double cost_before = 0, cost = 0;
  Play play;  ///< with the allocated clearances
  int rounds = 0;
};

/// Allocates the clearances of the joints of `costs` for the only quantity of `options`; others keep theirs. Throws
/// ModelError for unknown joints, and if the target cannot be met within the limits.
Allocation allocate_clearances(const Scene& scene, const PlayOptions& options, double target,
                               const std::vector<ClearanceCost>& costs);

}  // namespace freeplay
