// Runs against closed-form solutions: pendulum, bouncing ball, block on a slope, ring and journal,
// contact laws.
#include "verification/claims/claim.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/dry_friction.hpp"
#include "verification/references/hertz_impact.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/references/ring_and_journal.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr double degree = M_PI / 180;

void pendulum(Findings& f) {
  const reference::Pendulum p{0.8, 0.01, 0.25, 9.81, 60 * degree};
  Scene scene;
  scene.mechanism.gravity = {0, -9.81};
  const double lean = p.amplitude - M_PI / 2;
  scene.mechanism.bodies.push_back(
      {"bar", p.mass, p.inertia, 0.25 * Vec2{std::cos(lean), std::sin(lean)}, lean, {0, 0}, 0});
  scene.mechanism.joints.push_back(RevoluteJoint{"pivot", {ground, 0}, {Vec2{0, 0}, Vec2{-p.arm, 0}}, {}});
  scene.run.duration = 10 * reference::pendulum_period(p) + 0.3;
  const double exact = reference::pendulum_state(p, scene.run.duration).angle;
  const auto angle = [&](Family family) { return test::simulate(scene, family).final_state.q[2] + M_PI / 2; };
  const std::string source = "elliptic functions (Whittaker, Analytical Dynamics, 1904)",
                    reason = "tolerance 1e-11 per step in units of the arm, some 10⁴ steps";
  const auto name = [](const char* scheme) {
    return claim_name("pendulum released at 60°", "angle 0.3 s after ten periods", scheme);
  };
  scene.penalty.tolerance = 1e-11;
  f.within(name("penalty"), "rad", angle(Family::penalty), exact, 1e-7, source, reason);
  scene.nonsmooth.scheme = Scheme::event_driven;
  scene.nonsmooth.tolerance = 1e-11;
  f.within(name("event-driven"), "rad", angle(Family::nonsmooth), exact, 1e-7, source, reason);
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  scene.nonsmooth.step = 1e-4;
  f.within(name("Moreau–Jean, h = 1e-4 s"), "rad", angle(Family::nonsmooth), exact, 1e-4, source,
           "second order: (ω h)²/12 of the phase, ω t = 60 rad, ω h = 5e-4, margin of 100");
}

void ball(Findings& f) {
  const reference::BouncingBall b{0.5, 9.81, 0.5};
  auto scene = read_scene(test::scene_file("bouncing_ball"));
  const auto run = test::simulate(scene, Family::nonsmooth);
  const auto touches = test::touches(run);
  f.within("bouncing ball: time of 10th impact [event-driven]", "s", touches.at(9).t,
           reference::ball_impact(b, 10).t, 1e-12, "geometric series",
           "rounding: free flight is a polynomial in time");
  double rest = NAN;
  for (const auto& e : run.events)
    if (e.kind == EventKind::contact) rest = e.t;
  f.within("bouncing ball: time of rest [event-driven]", "s", rest, reference::ball_accumulation_time(b),
           1e-9, "t₁ (1 + e)/(1 − e)",
           "required accuracy; the accumulation of impacts is ended in closed form");
}

void block(Findings& f) {
  for (const double mu : {0.5, 0.2}) {
    const reference::BlockOnSlope b{20 * degree, mu, 9.81, 1.5};
    auto scene = read_scene(test::scene_file("block_on_slope"));
    scene.mechanism.surfaces[0].friction = mu;
    const auto end = test::simulate(scene, Family::nonsmooth).final_state;
    f.within(claim_name("block sliding up a slope", fmt::format("position after 0.5 s, μ = {}", mu),
                        "event-driven"),
             "m", end.q[0], reference::block_state(b, scene.run.duration).position, 1e-10,
             "uniform acceleration under Coulomb friction",
             "tolerance 1e-10, and location of the end of sliding; the motion is a polynomial in time");
  }
}

void ring(Findings& f) {
  auto scene = read_scene(test::scene_file("ring"));
  scene.mechanism.surfaces[0].friction.reset();
  scene.run.duration = 0.05;
  scene.nonsmooth.scheme = Scheme::event_driven;
  const auto touches = test::touches(test::simulate(scene, Family::nonsmooth));
  const auto& m = scene.mechanism;
  const reference::RingAndJournal pair{m.bodies[0].mass, m.bodies[1].mass, 1e-3, 0.8};
  reference::PairState s{0, {0, 0}, {1e-4, -2e-4}, {0, 0}, {0.3, 0.2}};
  for (int i = 0; i < 5; ++i) {
    s = reference::after_flight(s, *reference::time_to_contact(s.eccentricity(), s.rate(), pair.clearance));
    const auto impact = reference::pair_impact(pair, s);
    if (i == 4) {
      f.within("free ring and journal: time of 5th impact [event-driven]", "s", touches.at(4).t, s.t, 1e-12,
               "uniform motion between impacts, Newton's law", "rounding: free flight is linear in time");
      f.relative("free ring and journal: impulse of 5th impact [event-driven]", "N s",
                 touches.at(4).impulse_n, impact.impulse, 1e-9, "m (1 + e) v", "rounding");
    }
    s = impact.after;
  }
}

/// A head-on impact of a journal in its free ring: only the contact law acts.
void free_impacts(Findings& f) {
  auto scene = read_scene(test::scene_file("ring"));
  scene.mechanism.surfaces[0].friction.reset();
  scene.mechanism.bodies[0].angular_velocity = 0;
  scene.mechanism.bodies[1].position = {0, 0};
  scene.mechanism.bodies[1].velocity = {0.3, 0};
  scene.mechanism.bodies[1].angular_velocity = 0;
  scene.run.duration = 0.005;
  scene.penalty.integrator = Integrator::dopri5;
  scene.penalty.tolerance = 1e-12;
  const double mass = 2.0 * 0.5 / 2.5;
  const auto impact = [&] { return test::touch(test::simulate(scene, Family::penalty), 0); };

  scene.penalty.contact = ContactLaw::hertz;
  const auto run = test::simulate(scene, Family::penalty);
  const double K = run.contacts[0].model.stiffness;
  const auto exact = reference::elastic_impact(K, mass, 0.3);
  f.relative(
      "free impact of steel ring and journal: contact stiffness, bearing 20 mm, clearance 1 mm [Hertz]",
      "N/m^1.5", K, 4.0 / 3 * 207e9 / (2 * (1 - 0.09)) * std::sqrt(20e-3 * 19e-3 / 1e-3), 1e-12,
      "K = (4/3) E/(2(1 − ν²)) √(R_i R_j/(R_i − R_j))", "rounding");
  f.relative("free impact of steel ring and journal: greatest penetration [Hertz]", "m",
             run.contacts[0].penetration, exact.depth, 2e-3, "(5 m v²/(4 K))^(2/5) (Hertz 1881)",
             "evaluated at the ends of steps only: too small by up to (h ω)²/8");
  f.relative("free impact of steel ring and journal: duration [Hertz]", "s", test::touch(run, 0).duration,
             exact.duration, 1e-8, "2.9432755… δ/v",
             "required accuracy; δ^(3/2) is not smooth at contact onset, tolerance 1e-12");
  const char* const subject = "free impact of steel ring and journal";
  for (const double e : {0.1, 0.46, 0.9}) {
    scene.penalty.contact = ContactLaw::exact;
    scene.mechanism.surfaces[0].restitution = e;
    const auto touch = impact();
    f.within(claim_name(subject, fmt::format("delivered restitution at e = {}", e), "exact law"), "",
             -touch.v_n_plus / touch.v_n_minus, e, 1e-7, "χ(1 + e) = ln[(1 + χ)/(1 − χe)]",
             "tolerance 1e-12 per step of a ratio of speeds");
  }
  scene.penalty.contact = ContactLaw::lankarani_nikravesh;
  scene.mechanism.surfaces[0].restitution = 0.46;
  const auto touch = impact();
  f.within(claim_name(subject, "delivered restitution at e = 0.46", "Lankarani–Nikravesh"), "",
           -touch.v_n_plus / touch.v_n_minus, 0.715, 5e-4,
           "χ(1 + e) = ln[(1 + χ)/(1 − χe)] with χ = ¾(1 − e²)", "digits of the published table");
}

}  // namespace

Parts closed_forms() { return {pendulum, ball, block, ring}; }
Parts restitution() { return {free_impacts}; }

}  // namespace freeplay::verification
