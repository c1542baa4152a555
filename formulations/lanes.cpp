#include "formulations/lanes.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "formulations/marched.hpp"
#include "formulations/time_stepping/lane_group.hpp"
#include "formulations/time_stepping/moreau.hpp"
#include "simulation/watch.hpp"

namespace freeplay {
namespace {

using Laned = Marched<MoreauStepper>;

/// Ordinary steps that are worth the way into a lane and out of it.
constexpr double fewest_ordinary = 8;
/// After as many steps, stop requests are looked for.
constexpr double most_at_once = 1000;

struct Lane {
  const LaneRun* run = nullptr;  // null: none
  Laned* formulation = nullptr;
  std::unique_ptr<Laned::Steps> steps;
  bool inside = false;
  double left = 0;  // steps until it must leave

  /// Number of steps that nobody sees: to the step that ends last before the time of the next shown one.
  /// The last steps of a run are its own, since they may be shorter.
  double unseen() const {
    const auto& s = formulation->stepper();
    const double end = std::min(run->next_shown(), run->until);
    return std::min(std::floor((end - s.t()) / s.fixed_length() - 1.01), most_at_once);
  }
};

}  // namespace

bool fits_lanes(Formulation& formulation) {
  auto* f = dynamic_cast<Laned*>(&formulation);
  return f && LaneGroup::fits(f->stepper());
}

std::vector<Ending> run_in_lanes(const LaneFunctions& functions, const std::vector<LaneRun>& runs,
                                 long& in_lanes) {
  const auto formulation_of = [](const LaneRun& run) { return dynamic_cast<Laned*>(run.formulation); };
  std::vector<Ending> endings(runs.size());
  std::vector<Lane> lanes(static_cast<std::size_t>(functions.lanes));
  LaneGroup group(functions, formulation_of(runs.front())->stepper());
  std::size_t next = 0;
  const auto enter = [&](int i, Lane& lane) {
    const auto& run = runs[next++];
    lane.run = &run;
    lane.formulation = formulation_of(run);
    lane.steps = std::make_unique<Laned::Steps>(lane.formulation->march(run.until, *run.watch));
    group.enter(i, {&lane.formulation->stepper(), run.constants, &lane.formulation->passed()});
  };
  const auto finish = [&](Lane& lane) {
    endings[static_cast<std::size_t>(lane.run - runs.data())] =
        lane.formulation->finish(*lane.steps, *lane.run->watch);
    lane.run = nullptr;
  };
  // Steps of a run alone until it may be loaded, or its end
  const auto walk = [&](int i, Lane& lane) {
    while (lane.steps->step()) {
      lane.left = lane.unseen();
      if (!(lane.left >= fewest_ordinary && group.ready(i))) continue;
      group.load(i);
      lane.inside = true;
      return;
    }
    finish(lane);
  };
  for (;;) {
    unsigned inside = 0;
    double most = most_at_once;
    for (int i = 0; i < functions.lanes; ++i) {
      auto& lane = lanes[static_cast<std::size_t>(i)];
      while (!lane.inside && (lane.run || next < runs.size())) {
        if (!lane.run) enter(i, lane);
        walk(i, lane);
      }
      if (!lane.inside) continue;
      inside |= 1u << i;
      most = std::min(most, lane.left);
    }
    if (inside == 0) return endings;
    const unsigned leaving = group.advance(inside, static_cast<long>(most));
    for (int i = 0; i < functions.lanes; ++i) {
      auto& lane = lanes[static_cast<std::size_t>(i)];
      if (!lane.inside) continue;
      const bool leaves = (leaving >> i & 1) != 0;
      const long done = group.done() + (leaving != 0 && !leaves ? 1 : 0);
      lane.left -= static_cast<double>(done);
      in_lanes += done;
      if (!leaves && lane.left >= 1) continue;
      group.store(i);
      lane.inside = false;
    }
  }
}

}  // namespace freeplay
