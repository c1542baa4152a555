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
  std::string joint;    ///< name
  double cost = 1;      ///< b_k > 0, at the clearance of the scene
  double exponent = 1;  ///< p_k > 0
  double least = 0;     ///< m, > 0
  double greatest = 0;  ///< m, ≥ least
};

/// Clearance of one joint before and after the allocation.
struct AllocatedClearance {
  std::string joint;  ///< name
  double before = 0;  ///< m, of the scene
  double after = 0;   ///< m
  double cost = 0;    ///< with `after`
  /// Which limit of ClearanceCost the clearance has.
  enum class Limit { none, least, greatest };
  Limit limit = Limit::none;  ///< none: between both
};

/// Clearances of least cost.
struct Allocation {
  std::vector<AllocatedClearance> clearances;  ///< in the order of the costs
  double cost_before = 0;                      ///< with the clearances of the scene
  double cost = 0;                             ///< with the allocated ones
  Play play;                                   ///< with the allocated clearances
  int rounds = 0;                              ///< of the convex problem
};

/// Allocates the clearances of the joints of `costs` for the only quantity of `options`, whose width (m or rad) then is
/// at most `target`; others keep theirs. Throws ModelError as find_play() does, for unknown joints and wrong costs, and
/// if the target cannot be met within the limits.
Allocation allocate_clearances(const Scene& scene, const PlayOptions& options, double target,
                               const std::vector<ClearanceCost>& costs);

}  // namespace freeplay
