// Compares steps in lanes with those of each system alone, before a run uses them.
#include <algorithm>
#include <cmath>
#include <memory>

#include "dynamics/system_functions.hpp"
#include "dynamics/system_tracer.hpp"
#include "formulations/time_stepping/lane_group.hpp"
#include "formulations/time_stepping/lanes.hpp"
#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {
namespace {

constexpr int steps_compared = 20;

/// A stepper with its log.
struct OneStepper {
  OneStepper(const System& system, const State& from, double h, RowFacts facts)
      : log(system.contacts(), system.reported()),
        stepper(system, {}, h, std::vector<double>(static_cast<std::size_t>(system.reported()), 0.5), facts) {
    stepper.start(from, log);
  }
  /// Products with 0 vanish in compiled functions, so a motion that overflows is another one.
  bool overflows() const {
    return std::ranges::any_of(stepper.data().v, [](double v) { return !(std::abs(v) <= 1e50); });
  }
  /// Appends its quantities in one order; without multipliers, which steps in lanes do not keep.
  void put(std::vector<double>& all) const {
    const auto& d = stepper.data();
    for (const auto* list : {&d.q, &d.v}) all.insert(all.end(), list->begin(), list->end());
    for (const auto& c : stepper.contacts().all()) all.insert(all.end(), {c.gap, c.last_n, c.last_t});
    const auto& works = stepper.integrals();
    all.insert(all.end(), {works.drive, works.load, works.contact, works.friction, works.stabilisation,
                           stepper.extremes().constraint_length, stepper.extremes().constraint_angle});
  }
  ContactLog log;
  MoreauStepper stepper;
};

/// The quantities of some steps of h (s), in one order.
std::vector<double> stepped(const System& system, const State& from, double h, RowFacts facts) {
  OneStepper one(system, from, h, facts);
  std::vector<double> all;
  for (int i = 0; i < steps_compared && one.stepper.step(INFINITY) && !one.overflows(); ++i) {
    one.put(all);
    const auto& lambda = one.stepper.data().lambda;
    all.insert(all.end(), lambda.begin(), lambda.end());
  }
  return all;
}

}  // namespace

long differing_steps(System& system, const SystemFunctions& functions, const State& near, RowFacts facts,
                     int states) {
  const auto still = still_coordinates(system, near);
  long differing = 0;
  for (unsigned seed = 0; seed < std::min(4u, static_cast<unsigned>(states)); ++seed) {
    const auto at = seed == 0 ? near : moved(system, near, still, seed);
    const double h = seed < 3 ? 1e-5 : 1e-3;
    system.compiled().attach({});
    const auto expected = stepped(system, at, h, facts);
    system.compiled().attach(functions);
    differing += differing_numbers(stepped(system, at, h, facts), expected);
  }
  if (const auto lane = single_lane(system); lane.lanes > 0)
    differing += differing_lanes(lane, {{&system, &near, &functions.constants}}, facts, states);
  system.compiled().attach({});
  return differing;
}

long differing_lanes(const LaneFunctions& functions, const std::vector<LaneCheck>& lanes, RowFacts facts,
                     int states) {
  long differing = 0;
  for (unsigned seed = 0; seed < std::min(4u, static_cast<unsigned>(states)); ++seed) {
    const double h = seed < 3 ? 1e-5 : 1e-3;
    std::vector<std::unique_ptr<OneStepper>> alone, together;
    std::vector<double> passed(lanes.size());
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      const auto& lane = lanes[i];
      const auto still = still_coordinates(*lane.system, *lane.near);
      const auto at = seed == 0 ? *lane.near : moved(*lane.system, *lane.near, still, seed);
      alone.push_back(std::make_unique<OneStepper>(*lane.system, at, h, facts));
      together.push_back(std::make_unique<OneStepper>(*lane.system, at, h, facts));
    }
    LaneGroup group(functions, together.front()->stepper);
    for (std::size_t i = 0; i < lanes.size(); ++i)
      group.enter(static_cast<int>(i), {&together[i]->stepper, lanes[i].constants, &passed[i]});
    unsigned inside = 0;
    for (int step = 0; step < steps_compared; ++step) {
      const unsigned leaving = inside == 0 ? 0 : group.advance(inside, 1);
      std::vector<double> found, expected;
      for (std::size_t i = 0; i < lanes.size(); ++i) {
        const int lane = static_cast<int>(i);
        const bool made = (inside >> i & 1) != 0 && (leaving >> i & 1) == 0;
        if ((inside >> i & 1) != 0) group.store(lane);
        inside &= ~(1u << i);
        if (!alone[i]->stepper.step(INFINITY)) return differing;
        if (!made && !together[i]->stepper.step(INFINITY)) return differing + 1;
        if (alone[i]->overflows()) continue;
        alone[i]->put(expected);
        together[i]->put(found);
        if (!group.ready(lane)) continue;
        group.load(lane);
        inside |= 1u << i;
      }
      differing += differing_numbers(found, expected);
    }
  }
  return differing;
}

}  // namespace freeplay
