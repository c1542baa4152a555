// Growth of the differences that errors of impacts cause: one column of the variational equations along an
// event-driven run, which responds to impacts that are late or too strong (docs/theory/lyapunov.md).
// `compare` predicts by it where two formulations part.
#pragma once

#include <string>
#include <vector>

#include "formulations/variation/sensitivity.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

struct GrowthRequest {
  /// of the successive impacts of each contact; the last one holds for those after
  std::vector<std::vector<ImpactError>> errors;
  std::vector<double> restitution;  ///< of each contact
  double end = 0;                   ///< s
  long most_evaluations = 0;        ///< of the right-hand side, the column included
  StopToken stop = {};
};

/// An onset of contact with its differences.
struct GrownOnset {
  int contact = 0;
  double t = 0, rate = 0;                ///< s; m/s, rate of the gap before
  double t_change = 0, rate_change = 0;  ///< of both, to first order
};

struct Growth {
  std::vector<GrownOnset> onsets;  ///< in the order of time
  double until = 0;                ///< s: the list is complete up to here
  std::string ended;               ///< why that is before the end; empty if it is the end
  /// whether it ends because a difference exceeds the time since the onset before
  bool parted = false;
};

/// Runs the scene event-driven to `end`, or until a difference exceeds the time since the onset before.
/// Throws ModelError if the event-driven scheme cannot run the scene.
Growth growth_of_impact_errors(const Scene& scene, const GrowthRequest& request);

}  // namespace freeplay
