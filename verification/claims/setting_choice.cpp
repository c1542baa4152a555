// Adaptive time stepping and the automatic scheme, which hands over to it: cost, convergence, and
// continuity of events, energy and momentum across handovers.
#include "verification/claims/claim.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/support/handovers.hpp"
#include "verification/support/piles.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr const char* adaptive = "Moreau–Jean, adaptive steps";

Scene by(Scene scene, Scheme scheme, double tolerance = 1e-6) {
  scene.run.discard = 0;
  scene.instruments.clear();
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.step.reset();
  scene.nonsmooth.step_tolerance = tolerance;
  return scene;
}

Result finished(const Scene& scene) { return test::finished(scene, Family::nonsmooth); }

/// The first six impacts of the paper's slider-crank.
void rig(Findings& f) {
  const char* const subject = "paper's slider-crank with clearance";
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
  f.at_most(claim_name(subject, "times of first 6 impacts, greatest error", adaptive), "s",
            worst(test::touches(run)), 1e-6, "event-driven at 1e-13",
            "required accuracy; 20000 fixed steps of 1e-6 s have an error of 5e-6 s");
  f.at_most(claim_name(subject, "velocity solutions up to the 6th impact, rejected steps included", adaptive),
            "", static_cast<double>(run.work.rhs), 2000, "", "required cost: a tenth of 20000 fixed steps");
  scene.run.duration += 1e-4;  // an impact may be late
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
      claim_name(subject, "exponent of nonsmooth.step_tolerance in the error of impact times, 1e-7 to 2e-4",
                 adaptive),
      "", test::observed_order(accepted, errors), 0.7, 1.3, "",
      "1 from contacts located to 0.1 to 1 tolerance × clearance, 1 to 4/3 from the smooth motion before");
}

/// A body on a spring: the order where forces depend on position alone.
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
  f.between(claim_name("mass on a spring", "order of the error in the number of solutions", adaptive), "",
            test::observed_order(each, errors), 3.7, 4.3, "y = y₀ + a cos ωt",
            "4: extrapolation from one step and two half steps of a symmetric method of order 2");
}

/// A journal that slides round its bearing: the order with a rotating normal and friction
/// proportional to the normal force.
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
      claim_name("journal sliding round its bearing", "order of the error in the number of solutions",
                 adaptive),
      "", test::observed_order(each, errors), 2.5, 3.5, "v = v₀/(1 + μ v₀ t/c), φ = ln(1 + μ v₀ t/c)/μ",
      "3: friction over the rotation of the last half step is of third order, as is the accepted error");
  f.at_most(claim_name("journal sliding round its bearing",
                       "greatest error of speed and angle over the tolerance 1e-6", adaptive),
            "", errors[1] / 1e-6, 30, "v = v₀/(1 + μ v₀ t/c), φ = ln(1 + μ v₀ t/c)/μ",
            "some 160 steps that each err by up to a tolerance, by a third of it after extrapolation");
}

void at_rest(Findings& f) {
  auto scene = by(read_scene(test::scene_file("bouncing_ball")), Scheme::moreau_jean);
  scene.run.duration = 1.2;
  const auto run = finished(scene);
  const reference::BouncingBall ball{0.5, 9.81, 0.5};
  const auto found = test::touches(run);
  double reported = 0, beyond = 0;  // beyond: the greatest error over the reported uncertainty
  for (std::size_t k = 0; k + 1 < found.size(); ++k) {
    reported += found[k].t_uncertainty;
    beyond = greatest(beyond, std::abs(found[k].t - reference::ball_impact(ball, static_cast<int>(k) + 1).t) /
                                  (3 * reported + 1e-12));
  }
  f.at_most(
      claim_name("bouncing ball", "times of impacts, greatest error over reported uncertainty", adaptive), "",
      beyond, 1, "t_k = t₁ (1 + 2 (e + … + e^{k−1}))",
      "an impact δ late delays all later ones by up to δ (1 + e)/(1 − e) = 3 δ: three times the sum of "
      "the reported "
      "uncertainties");
  f.at_most(claim_name("bouncing ball", "time of rest, error over reported uncertainty", adaptive), "",
            std::abs(found.back().t - reference::ball_accumulation_time(ball)) /
                (3 * reported + found.back().t_uncertainty),
            1, "t_∞ = t₁ (1 + e)/(1 − e)",
            "the contact that ends the bounces reports the duration of the omitted ones");
  const double low = 1e-6 * 1e-3 * 0.05;
  f.within(claim_name("bouncing ball", "number of impacts", adaptive), "", static_cast<double>(found.size()),
           std::ceil(std::log(0.5 / low) / std::log(4.0)) + 1, 0, "height of bounce k: 0.5 m × e^{2k}",
           "exact: the first bounce below tolerance × a thousandth of the radius is the last");
  auto ring = by(read_scene(test::scene_file("ring")), Scheme::moreau_jean);
  ring.mechanism.surfaces[0].restitution = 1;
  ring.mechanism.surfaces[0].friction.reset();
  const auto l = finished(ring).ledger;
  f.at_most(
      claim_name("free ring and journal, e = 1", "relative change of kinetic energy in 0.5 s", adaptive), "",
      std::abs(l.kinetic / l.initial - 1), 1e-11, "0: elastic impacts, no forces",
      "rounding of some hundred impacts: u⁺ = −u⁻ makes the mean velocity of a step zero");
}

/// A block whose sliding reverses, from several starting velocities: errors over the accepted ones.
void turning_friction(Findings& f) {
  double worst = 0;
  for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7})
    for (const double v0 : {0.25, 0.27, 0.3, 0.31, 0.32}) {
      auto scene = read_scene(test::scene_file("pulled_block"));
      scene.mechanism.bodies[0].velocity = {v0, 0};
      const auto end = finished(by(scene, Scheme::moreau_jean, tolerance)).final_state;
      worst = greatest(worst, std::abs(end.v[0] + 2 * (0.2 - v0 / 8)) / (tolerance * (std::sqrt(9.81) + v0)));
    }
  f.at_most(claim_name("block reversed by a pull against preloaded friction",
                       "velocity error over tolerance, greatest of 20 runs", adaptive),
            "", worst, 2, "m v̇ = −F ∓ R",
            "a step across the reversal errs by the tolerance, and so may one that ends there");
}

void handovers(Findings& f) {
  const auto rig = read_scene(test::flores());
  const auto events = finished(by(rig, Scheme::event_driven)), whole = finished(by(rig, Scheme::automatic));
  int differ = std::abs(static_cast<int>(events.events.size()) - static_cast<int>(whole.events.size()));
  for (std::size_t i = 0; i < std::min(events.events.size(), whole.events.size()); ++i)
    differ +=
        events.events[i].t != whole.events[i].t || events.events[i].impulse_n != whole.events[i].impulse_n;
  f.within(claim_name("paper's slider-crank with clearance",
                      "events that differ from the event-driven scheme", "automatic"),
           "", differ, 0, 0, "event-driven run", "exact, bit for bit: there is no handover");
  int unfinished = 0, turns = 0;
  double energy = 0, momentum = 0, impulses = 0;
  const std::pair<std::string, double> all[] = {{loop, 1.46593092926e-05},
                                                {wedge, 1.5},
                                                {test::random_pile(1), 0.6},
                                                {test::random_pile(8), 0.3},
                                                {test::random_pile(11), 0.3}};
  for (const auto& [text, duration] : all) {
    auto scene = by(parse_scene(text, "handover"), Scheme::automatic);
    scene.run.duration = duration;
    const auto b = booked(scene);
    unfinished += b.result.ending.status != Ending::Status::finished;
    turns += b.out_of_turn;
    energy = greatest(energy, std::abs(b.result.ledger.closure()) / b.result.ledger.scale());
    momentum = greatest(momentum, greatest(b.momentum, b.moment));
    impulses = greatest(impulses, b.impulses);
  }
  const auto name = [](const char* quantity) {
    return claim_name("fast four-bar with clearance, disc in a wedge, three piles", quantity, "automatic");
  };
  f.within(name("unfinished runs"), "", unfinished, 0, 0, "0",
           "exact; the event-driven scheme alone does not finish the first");
  f.within(name("contact onsets and separations that do not alternate"), "", turns, 0, 0, "0",
           "exact: no event is lost or doubled at a handover");
  f.at_most(name("impulses of events less those of steps"), "", impulses, 1e-4,
            "∫ F_N dt and the steps' impacts",
            "forces of a smooth step are extrapolated, impulses of events are not: 1e-6 per step, "
            "some tens of steps");
  f.at_most(name("greatest error of the energy balance"), "", energy, 1e-6, "0",
            "energies have the error of the state, at most 1e-6 of its scale per step");
  f.at_most(name("change of each body's momentum less impulses"), "", momentum, 1e-6,
            "Newton–Euler equations",
            "momenta have the error of the state, at most 1e-6 of its scale per step");
}

}  // namespace

Parts setting_choice() { return {rig, smooth, sliding, at_rest, turning_friction, handovers}; }

}  // namespace freeplay::verification
