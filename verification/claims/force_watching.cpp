// Observing forces changes no result, and undetermined reactions are listed.
#include "verification/claims/force_claims.hpp"
#include "verification/references/bearing_load.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::force_claims {
namespace {

/// The number of values of two runs that differ in any bit.
long differing(const Result& a, const Result& b) {
  long n = a.events.size() != b.events.size();
  const auto differ = [&](const auto& x, const auto& y) { n += !(x == y); };
  differ(a.t_end, b.t_end);
  differ(a.final_state.q, b.final_state.q);
  differ(a.final_state.v, b.final_state.v);
  for (std::size_t i = 0; i < std::min(a.events.size(), b.events.size()); ++i) {
    const auto &x = a.events[i], &y = b.events[i];
    for (const auto field :
         {&Event::t, &Event::v_n_minus, &Event::v_n_plus, &Event::v_t_minus, &Event::v_t_plus,
          &Event::impulse_n, &Event::impulse_t, &Event::duration, &Event::t_uncertainty})
      differ(x.*field, y.*field);
    differ(x.joint, y.joint);
    n += x.kind != y.kind;
  }
  for (const auto field : {&Work::steps, &Work::rejected, &Work::rhs, &Work::jacobians, &Work::factorisations,
                           &Work::lcp_solves, &Work::lcp_retries, &Work::pivots, &Work::events})
    differ(a.work.*field, b.work.*field);
  for (const auto field :
       {&EnergyLedger::kinetic, &EnergyLedger::potential, &EnergyLedger::drive, &EnergyLedger::load,
        &EnergyLedger::contact, &EnergyLedger::friction, &EnergyLedger::stabilisation})
    differ(a.ledger.*field, b.ledger.*field);
  return n;
}

}  // namespace

void watching(Findings& f) {
  const auto start = start_of_everything();
  const auto compare = [&](const char* scheme, const Scene& scene, Family family) {
    BalanceWatch watch(scene.mechanism, false, 1e-4, 5);
    const auto watched = run(scene, family, {&watch}, start), alone = run(scene, family, {}, start);
    f.within(claim_name("scene with one of each element",
                        "values (state, events, work, energies) changed by observing the forces", scheme),
             "", double(differing(watched, alone)), 0, 0, "0", "exact: bit for bit");
  };
  for (const auto integrator : {Integrator::dopri5, Integrator::adams_bashforth_moulton})
    compare(integrator == Integrator::dopri5 ? "penalty, dopri5, projection"
                                             : "penalty, Adams–Bashforth–Moulton, Baumgarte",
            penalty({"", integrator,
                     integrator == Integrator::dopri5 ? Stabilisation::projection : Stabilisation::baumgarte,
                     FrictionLaw::ambrosio, ContactLaw::exact, 4e-3}),
            Family::penalty);
  compare("event-driven", nonsmooth(Scheme::event_driven), Family::nonsmooth);
  compare("Moreau–Jean, h = 1e-5 s", nonsmooth(Scheme::moreau_jean), Family::nonsmooth);
}

void redundant(Findings& f) {
  const auto start = start_of_everything();
  auto scene = everything();
  scene.run.duration = 1e-5;
  BalanceWatch watch(scene.mechanism, false, 1e-5);
  auto found = run(scene, Family::penalty, {&watch}, start).undetermined;
  std::ranges::sort(found);
  f.within(claim_name("scene with one of each element", "mismatch of the list of undetermined reactions",
                      "penalty"),
           "", found == std::vector<std::string>{"guide", "guide_twin", "main", "main_twin"} ? 0 : 1, 0, 0,
           "those of the double pin and the double guide: equal constraint rows; all others are independent",
           "exact");
  // Two pins at one place: the sum of their forces is that of a single pin.
  const auto s = loaded();
  auto twice = slider_crank(s);
  twice.mechanism.joints.push_back(RevoluteJoint{"twin", {ground, 0}, {Vec2{0, 0}, Vec2{-0.02, 0}}, {}});
  // A door on two parallel guides: the sum of their forces is that of a single guide.
  Scene door;
  const reference::GuidedBody<double> body{6.0, 0.5 * std::numbers::pi, {0.3, -0.2}, {20, 5}, {0.5, 0.1}};
  door.mechanism.gravity = {0.4, -9.81};
  door.mechanism.bodies.push_back({"door", 6.0, 0.4, {0.3, -0.2}, 0, {0, 0}, 0});
  door.mechanism.joints.push_back(
      TranslationalJoint{"near", {ground, 0}, {Vec2{0, 0}, Vec2{-0.3, 0.2}}, {0, 1}, 0, {}});
  door.mechanism.joints.push_back(
      TranslationalJoint{"far", {ground, 0}, {Vec2{0.6, 0}, Vec2{0.3, 0.2}}, {0, 1}, 0, {}});
  door.mechanism.loads.push_back(ForceLoad{"hand", 0, {0.2, 0.3}, {20, 5}});
  door.run.duration = 0.05;
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    twice.nonsmooth.scheme = door.nonsmooth.scheme = Scheme::event_driven;
    const char* const name = family == Family::penalty ? "penalty" : "event-driven";
    const auto watch_forces = [&](const Scene& each, auto look) {
      Simulation simulation(each, test::name_of(family));
      Forces now{std::vector<ElementForce>(simulation.layout().forces.size()),
                 std::vector<double>(3 * each.mechanism.bodies.size())};
      double off = 0;
      auto list = test::watch_steps(simulation, [&](const Step& step) {
                    step.forces(step.t1, now);
                    off = greatest(off, look(step.t1, now.elements, simulation.layout()));
                  }).undetermined;
      std::ranges::sort(list);
      return std::pair{off, list};
    };
    const auto [pins, marked] = watch_forces(twice, [&](double t, const auto& e, const Layout& l) {
      const auto exact = reference::slider_crank_forces(s, s.speed * t);
      const auto &a = e[find(l, "main")], &b = e[find(l, "twin")], &c = e[find(l, "big_end")];
      return std::max(
          {std::hypot(a.fx + b.fx - exact.ground_on_crank.x, a.fy + b.fy - exact.ground_on_crank.y),
           std::hypot(c.fx - exact.crank_on_rod.x, c.fy - exact.crank_on_rod.y)});
    });
    f.at_most(claim_name("crank on two coincident pins",
                         "sum of pin forces and big-end force, greatest error", name),
              "N", pins, 1e-5, "references/slider_crank", "tolerance 1e-10 of some 300 N, margin of 300");
    f.within(
        claim_name("crank on two coincident pins", "mismatch of the list of undetermined reactions", name),
        "", marked == std::vector<std::string>{"main", "twin"} ? 0 : 1, 0, 0,
        "those of the two pins: equal constraint rows", "exact");
    const auto [guides, held] = watch_forces(door, [&](double, const auto& e, const Layout& l) {
      const Point g{0.4, -9.81};
      const auto exact = reference::guide_load(body, reference::guided_acceleration(body, g), g);
      const auto &a = e[find(l, "near")], &b = e[find(l, "far")];
      return std::max({std::abs(a.fx + b.fx - exact.joint.force.x),
                       std::abs(a.fy + b.fy - exact.joint.force.y),
                       std::abs(a.m + b.m + 0.6 * b.fy - exact.joint.moment)});
    });
    f.at_most(claim_name("door on two parallel guides",
                         "sum of guide forces and of their moments, greatest error", name),
              "N, N m", guides, 1e-10, "references/bearing_load", "rounding of some 60 N at two lever arms");
    f.within(
        claim_name("door on two parallel guides", "mismatch of the list of undetermined reactions", name), "",
        held == std::vector<std::string>{"far", "near"} ? 0 : 1, 0, 0,
        "those of the two guides: equal constraint rows", "exact");
  }
}

}  // namespace freeplay::verification::force_claims
