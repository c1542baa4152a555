#include "formulations/single_lane.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "formulations/marched.hpp"
#include "formulations/time_stepping/lane_group.hpp"
#include "formulations/time_stepping/moreau.hpp"
#include "simulation/watch.hpp"

namespace freeplay {
namespace {

/// Ordinary steps that are worth the way into the lane and out of it.
constexpr double fewest_lane_steps = 4;
/// After as many steps, stop requests are looked for.
constexpr double most_steps = 1000;

}  // namespace

Ending run_in_single_lane(Formulation& formulation, double until, Watch& watch,
                          const std::function<double()>& next_shown,
                          const std::function<const SingleLane*()>& lane) {
  auto* fixed = dynamic_cast<Marched<MoreauStepper>*>(&formulation);
  if (!fixed) return formulation.run(until, watch);
  auto& alone = *fixed;
  auto steps = alone.march(until, watch);
  const SingleLane* single = nullptr;
  std::optional<LaneGroup> group;
  // The last steps are the run's own, since they may be shorter.
  const auto unseen = [&] {
    const auto& s = alone.stepper();
    const double end = std::min(next_shown(), until);
    return std::min(std::floor((end - s.t()) / s.fixed_length() - 1.01), most_steps);
  };
  while (steps.step()) {
    if (!single) {
      single = lane();
      if (!single) continue;
      if (single->functions.lanes == 1) {
        group.emplace(single->functions, alone.stepper());
        group->enter(0, {&alone.stepper(), &single->constants, &alone.passed()});
      }
    }
    if (!group) continue;
    const double most = unseen();
    if (most < fewest_lane_steps || !group->ready(0)) continue;
    group->load(0);
    group->advance(1, static_cast<long>(most));
    group->store(0);
  }
  return alone.finish(steps, watch);
}

}  // namespace freeplay
