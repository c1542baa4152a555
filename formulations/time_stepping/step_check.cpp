#include "formulations/time_stepping/step_check.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/system_functions.hpp"
#include "dynamics/system_tracer.hpp"
#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {
namespace {

/// The quantities of some steps of h (s), in one order.
std::vector<double> stepped(const System& system, const State& from, double h, RowFacts facts) {
  constexpr int steps = 20;
  ContactLog log(system.contacts(), system.reported());
  MoreauStepper stepper(system, {}, h, std::vector<double>(static_cast<std::size_t>(system.reported()), 0.5),
                        facts);
  stepper.start(from, log);
  std::vector<double> all;
  for (int i = 0; i < steps && stepper.step(INFINITY); ++i) {
    const auto& d = stepper.data();
    // Products with 0 vanish in compiled functions, so a motion that overflows is another one.
    if (std::ranges::any_of(d.v, [](double v) { return std::abs(v) > 1e50; })) break;
    for (const auto* list : {&d.q, &d.v, &d.lambda}) all.insert(all.end(), list->begin(), list->end());
    for (const auto& c : stepper.contacts().all()) all.insert(all.end(), {c.gap, c.last_n, c.last_t});
    const auto& works = stepper.integrals();
    all.insert(all.end(), {works.drive, works.load, works.contact, works.friction, works.stabilisation,
                           stepper.extremes().constraint_length, stepper.extremes().constraint_angle});
  }
  return all;
}

}  // namespace

long differing_steps(System& system, const SystemFunctions& functions, const State& near, RowFacts facts) {
  const auto still = still_coordinates(system, near);
  long differing = 0;
  for (unsigned seed = 0; seed < 4; ++seed) {
    const auto at = seed == 0 ? near : moved(system, near, still, seed);
    const double h = seed < 3 ? 1e-5 : 1e-3;
    system.attach({});
    const auto expected = stepped(system, at, h, facts);
    system.attach(functions);
    const auto found = stepped(system, at, h, facts);
    if (found.size() != expected.size()) ++differing;
    for (std::size_t i = 0; i < found.size() && i < expected.size(); ++i)
      if (!(found[i] == expected[i] || (std::isnan(found[i]) && std::isnan(expected[i])))) ++differing;
  }
  system.attach({});
  return differing;
}

}  // namespace freeplay
