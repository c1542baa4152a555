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
constexpr double fewest_steps = 8;
/// After as many steps, stop requests are looked for.
constexpr double most_steps = 1000;

struct Lane {
  Laned* formulation = nullptr;
  const LaneRun* run = nullptr;
  std::unique_ptr<Laned::Steps> steps;
  bool inside = false, over = false;
  double left = 0;  // steps until it must leave

  /// Number of steps that nobody sees. The last steps of a run are its own, since they may be shorter.
  double unseen() const {
    const auto& s = formulation->stepper();
    const double end = std::min(run->next_shown(), run->until);
    return std::min(std::floor((end - s.t()) / s.fixed_length()) - 3, most_steps);
  }
};

}  // namespace

bool fits_lanes(Formulation& formulation) {
  auto* f = dynamic_cast<Laned*>(&formulation);
  return f && LaneGroup::fits(f->stepper());
}

std::vector<Ending> run_in_lanes(const LaneFunctions& functions, const std::vector<LaneRun>& runs,
                                 long& in_lanes) {
  std::vector<Lane> lanes;
  std::vector<LaneGroup::Member> members;
  for (const auto& run : runs) {
    auto* f = dynamic_cast<Laned*>(run.formulation);
    lanes.push_back({.formulation = f, .run = &run});
    lanes.back().steps = std::make_unique<Laned::Steps>(f->march(run.until, *run.watch));
    members.push_back({&f->stepper(), run.constants, &f->passed()});
  }
  LaneGroup group(functions, members);
  // Steps of its own until a lane may be entered
  const auto walk = [&](int i) {
    auto& lane = lanes[static_cast<std::size_t>(i)];
    do {
      if (!lane.steps->step()) {
        lane.over = true;
        return;
      }
      lane.left = lane.unseen();
    } while (!(lane.left >= fewest_steps && group.ready(i)));
    group.load(i);
    lane.inside = true;
  };
  for (;;) {
    unsigned inside = 0;
    double most = most_steps;
    for (int i = 0; i < static_cast<int>(lanes.size()); ++i) {
      auto& lane = lanes[static_cast<std::size_t>(i)];
      if (!lane.inside && !lane.over) walk(i);
      if (!lane.inside) continue;
      inside |= 1u << i;
      most = std::min(most, lane.left);
    }
    if (inside == 0) break;
    const unsigned leaving = group.advance(inside, static_cast<long>(most));
    for (int i = 0; i < static_cast<int>(lanes.size()); ++i) {
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
  std::vector<Ending> endings;
  for (auto& lane : lanes) endings.push_back(lane.formulation->finish(*lane.steps, *lane.run->watch));
  return endings;
}

}  // namespace freeplay
