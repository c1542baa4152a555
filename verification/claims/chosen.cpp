// Time steps that are chosen by their error, and the default scheme that hands over to them: what they cost, how their error
// falls, and that nothing is lost between the schemes.
#include <fmt/format.h>

#include "mechanism/scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/support/handovers.hpp"
#include "verification/support/piles.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

namespace freeplay::verification {
namespace {

Scene by(Scene scene, Scheme scheme, double tolerance = 1e-6) {
  scene.run.discard = 0;
  scene.instruments.clear();
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.step.reset();
  scene.nonsmooth.step_tolerance = tolerance;
  return scene;
}

Result finished(const Scene& scene) { return test::finished(scene, Family::nonsmooth); }

/// The paper's first six touches.
void rig(Findings& f) {
  auto scene = read_scene(test::flores(), {"run.revolutions=0.2", "run.discard=0"});
  auto events = by(scene, Scheme::event_driven);
  events.nonsmooth.tolerance = 1e-13;
  const auto exact = test::touches(finished(events));
  const auto worst = [&](const std::vector<ContactEvent>& found) {
    double late = found.size() < 6 ? NAN : 0;
    for (std::size_t i = 0; i < 6 && i < found.size(); ++i)
      late = greatest(late, std::abs(found[i].t - exact.at(i).t));
    return late;
  };
  scene.run.duration = exact.at(5).t + 1e-5;
  const auto run = finished(by(scene, Scheme::moreau_jean));
  f.at_most("chosen steps: first six touches of the paper's rig, greatest error of their times", "s",
            worst(test::touches(run)), 1e-6, "event-driven at 1e-13",
            "the goal that was set; 20,000 fixed steps of 1e-6 s leave 5e-6 s");
  f.at_most("the same: velocity solves to just after the sixth, rejected steps included", "",
            static_cast<double>(run.work.rhs), 2000, "", "the goal that was set: a tenth of those steps");
  scene.run.duration += 1e-4;  // a touch may be late
  std::vector<double> accepted, errors;
  for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7}) {
    double late = 0;
    for (int part = 0; part < 10; ++part)
      late = greatest(
          late, worst(test::touches(finished(by(scene, Scheme::moreau_jean, tolerance * (1 + 0.1 * part))))));
    accepted.push_back(tolerance);
    errors.push_back(late);
  }
  f.between(
      "the same: slope of that error over nonsmooth.step_tolerance, 1e-7 to 2e-4", "",
      test::observed_order(accepted, errors), 0.7, 1.3, "",
      "a touch is landed on to 0.1 and acts within 1 tolerance × clearance: 1; smooth stretches before it 1 to 4/3");
}

/// A body on a spring: the order where forces know the place alone.
void smooth(Findings& f) {
  const auto scene = read_scene(test::scene_file("hanging_mass"));
  const double w = std::sqrt(80 / 2.0), rest = -(1 + 2 * 9.81 / 80), a = -1 - rest;
  std::vector<double> each, errors;
  for (double tolerance = 1e-4; tolerance > 0.9e-8; tolerance /= 10) {
    const auto run = finished(by(scene, Scheme::moreau_jean, tolerance));
    each.push_back(1.0 / static_cast<double>(run.work.rhs));
    errors.push_back(std::max(std::abs(run.final_state.q[1] - rest - a * std::cos(w * 1.3)) / a,
                              std::abs(run.final_state.v[1] + a * w * std::sin(w * 1.3)) / (a * w)));
  }
  f.between("chosen steps: a body on a spring, order of its error in the solves", "",
            test::observed_order(each, errors), 3.7, 4.3, "y = y₀ + a cos ωt",
            "one step and two halves of a symmetric method of order 2: their combination is of order 4");
}

/// A journal that slides round its bearing: the order where the normal turns and friction goes with what presses.
void sliding(Findings& f) {
  const double mu = 0.3, c = 1e-3, v0 = 1, t = 0.01;
  const auto scene = read_scene(test::scene_file("sliding_journal"));
  const double v = v0 / (1 + mu * v0 * t / c), angle = std::log(1 + mu * v0 * t / c) / mu;
  std::vector<double> each, errors;
  for (const double tolerance : {1e-5, 1e-6, 1e-7, 1e-8}) {
    const auto run = finished(by(scene, Scheme::moreau_jean, tolerance));
    const auto& s = run.final_state;
    each.push_back(1.0 / static_cast<double>(run.work.rhs));
    errors.push_back(
        greatest(std::abs(std::hypot(s.v[0], s.v[1]) - v) / v0,
                 std::abs(std::remainder(std::atan2(s.q[1], s.q[0]) - angle, 2 * 3.141592653589793))));
  }
  f.between(
      "chosen steps: a journal sliding round its bearing, order of its error in the solves", "",
      test::observed_order(each, errors), 2.5, 3.5, "v = v₀/(1 + μ v₀ t/c), φ = ln(1 + μ v₀ t/c)/μ",
      "the friction of the last half step's turning is of third order: an error in proportion to what is accepted, "
      "which falls with the cube of the steps");
  f.at_most("the same at 1e-6: greatest error of speed and angle over tolerance", "", errors[1] / 1e-6, 30,
            "the same",
            "some 160 steps that each miss by up to a tolerance, a third of it after extrapolation");
}

void at_rest(Findings& f) {
  auto scene = by(read_scene(test::scene_file("bouncing_ball")), Scheme::moreau_jean);
  scene.run.duration = 1.2;
  const auto run = finished(scene);
  const reference::BouncingBall ball{0.5, 9.81, 0.5};
  const auto found = test::touches(run);
  double told = 0, beyond = 0;  // the greatest error over what is told
  for (std::size_t k = 0; k + 1 < found.size(); ++k) {
    told += found[k].t_uncertainty;
    beyond = greatest(beyond, std::abs(found[k].t - reference::ball_impact(ball, static_cast<int>(k) + 1).t) /
                                  (3 * told + 1e-12));
  }
  f.at_most(
      "chosen steps: a ball's bounces, errors of their times over what is told", "", beyond, 1,
      "t_k = t₁ (1 + 2 (e + … + e^{k−1}))",
      "an impact δ late shifts the rest by δ (1 + e)/(1 − e) = 3 δ: three times the sum of what was told");
  f.at_most("the same: its coming to rest, error over what is told", "",
            std::abs(found.back().t - reference::ball_accumulation_time(ball)) /
                (3 * told + found.back().t_uncertainty),
            1, "t_∞ = t₁ (1 + e)/(1 − e)",
            "the touch that ends the hops tells how long they would have lasted");
  const double low = 1e-6 * 1e-3 * 0.05;
  f.within("the same: its touches", "", static_cast<double>(found.size()),
           std::ceil(std::log(0.5 / low) / std::log(4.0)) + 1, 0, "the k-th hop is 0.5 m × e^{2k} high",
           "the first hop below tolerance × a thousandth of the radius is the last: a count");
  auto ring = by(read_scene(test::scene_file("ring")), Scheme::moreau_jean);
  ring.mechanism.surfaces[0].restitution = 1;
  ring.mechanism.surfaces[0].friction.reset();
  const auto l = finished(ring).ledger;
  f.at_most("chosen steps: ring and journal, e = 1, half a second: change of the kinetic energy", "",
            std::abs(l.kinetic / l.initial - 1), 1e-11, "elastic, no forces",
            "u⁺ = −u⁻ makes the mean rate of a step zero: rounding of some hundred impacts");
}

/// Sliding that turns round: from how many starts it is off by more than what is accepted.
void turning_friction(Findings& f) {
  double worst = 0;
  for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7})
    for (const double v0 : {0.25, 0.27, 0.3, 0.31, 0.32}) {
      auto scene = read_scene(test::scene_file("pulled_block"));
      scene.mechanism.bodies[0].velocity = {v0, 0};
      const auto end = finished(by(scene, Scheme::moreau_jean, tolerance)).final_state;
      worst = greatest(worst, std::abs(end.v[0] + 2 * (0.2 - v0 / 8)) / (tolerance * (std::sqrt(9.81) + v0)));
    }
  f.at_most(
      "chosen steps: a block that a pull turns round against preloaded friction, 20 runs: error over tolerance",
      "", worst, 2, "m v̇ = −F ∓ R, by hand",
      "a step over the instant of turning is wrong by what is accepted, and so may be one that ends there");
}

void handovers(Findings& f) {
  const auto rig = read_scene(test::flores());
  const auto events = finished(by(rig, Scheme::event_driven)), whole = finished(by(rig, Scheme::automatic));
  int differ = std::abs(static_cast<int>(events.events.size()) - static_cast<int>(whole.events.size()));
  for (std::size_t i = 0; i < std::min(events.events.size(), whole.events.size()); ++i)
    differ +=
        events.events[i].t != whole.events[i].t || events.events[i].impulse_n != whole.events[i].impulse_n;
  f.within("automatic: events of the paper's rig that are not those of event-driven, to the last bit", "",
           differ, 0, 0, "event-driven", "nothing is handed over there, and watching for it moves nothing");
  int unfinished = 0, unhanded = 0, turns = 0;
  double energy = 0, momentum = 0, impulses = 0;
  const std::pair<std::string, double> all[] = {{loop, 1.46593092926e-05},
                                                {wedge, 1.5},
                                                {test::random_pile(1), 0.6},
                                                {test::random_pile(8), 0.3},
                                                {test::random_pile(11), 0.3}};
  for (const auto& [text, duration] : all) {
    auto scene = by(parse_scene(text, "handed over"), Scheme::automatic);
    scene.run.duration = duration;
    const auto b = booked(scene);
    unfinished += b.result.ending.status != Ending::Status::finished;
    unhanded += b.result.work.handovers == 0;
    turns += b.out_of_turn;
    energy = greatest(energy, std::abs(b.result.ledger.closure()) / b.result.ledger.scale());
    momentum = greatest(momentum, greatest(b.momentum, b.moment));
    impulses = greatest(impulses, b.impulses);
  }
  const std::string which = "a fast loose four-bar, a jamming disc, three piles";
  f.within("automatic: of " + which + ", runs that do not end or hand nothing over", "",
           unfinished + unhanded, 0, 0, "", "event-driven alone does not finish the first");
  f.within("the same: touches and losses of a contact that do not take turns", "", turns, 0, 0, "",
           "no event is lost in a hand-over, none doubled");
  f.at_most(
      "the same: impulses that events tell, less those of the steps", "", impulses, 1e-4,
      "∫ F_N dt and the steps' impacts",
      "forces of a smooth step are extrapolated, impulses of events are not: 1e-6 a step, some tens of steps");
  f.at_most("the same: greatest error of the energy balance", "", energy, 1e-6, "",
            "energies go with the state, 1e-6 of its scale a step at most");
  f.at_most("the same: change of each body's momentum less impulses", "", momentum, 1e-6, "Newton and Euler",
            "as above");
}

}  // namespace

Findings chosen() {
  Findings f;
  rig(f);
  smooth(f);
  sliding(f);
  at_rest(f);
  turning_friction(f);
  handovers(f);
  return f;
}

}  // namespace freeplay::verification
