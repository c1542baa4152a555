// Notes of a run about its own quality: doubtful results are reported with reason, by a measure
// that the model has, and no others.
#include "facade/assess.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "io/files/run_json.hpp"
#include "values/warning.hpp"
#include "verification/references/hertz_impact.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::notes_of;

namespace {

constexpr double mass = 0.033, radius = 0.02, height = 0.5, g = 9.81;

/// A ball that falls from a height onto a floor.
Scene ball(double young, double poisson, double restitution) {
  return parse_scene(
      fmt::format("gravity = [0.0, -{}]\n", g) +
          test::body("ball", mass, 5.3e-6, fmt::format("position = [0.0, {}]\n", radius + height)) +
          test::plane("floor", "ground", "ball", radius) +
          test::surface("s", restitution, fmt::format("young = {}\npoisson = {}\n", young, poisson)) +
          test::run_for(1.0) + "[penalty]\ncontact = \"exact\"\n",
      "ball");
}

}  // namespace

TEST_CASE("a ball's penetration is reported relative to its radius, its impacts relative to its flights",
          "[assess]") {
  // Hertz: sphere on a plane of like material, K = 4/3 E/(2(1 − ν²)) √R, v = √(2 g h).
  const double young = 207e9, poisson = 0.3, v = std::sqrt(2 * g * height);
  const double K = 4.0 / 3 * young / (2 * (1 - poisson * poisson)) * std::sqrt(radius);
  const auto exact = reference::elastic_impact(K, mass, v);
  const auto run = test::simulate(ball(young, poisson, 1), Family::penalty);
  const auto& c = run.contacts.at(0);
  CAPTURE(notes_of(run));
  CHECK(c.measure == "radius");
  // The ball's weight adds g δ to v²/2 during compression: 1e-5.
  CHECK(c.penetration_ratio == Approx(exact.depth / radius).epsilon(1e-4));
  CHECK(c.impact_over_flight == Approx(exact.duration / (2 * v / g)).epsilon(1e-2));
  CHECK(run.notes.empty());
  const auto j = to_json(run)["contacts"]["floor"];
  CHECK(j.contains("greatest_penetration_over_radius"));
  CHECK_FALSE(j.contains("greatest_penetration_over_clearance"));
  CHECK(j.contains("impact_over_flight"));
}

TEST_CASE("a contact that is too soft is reported as doubtful, by its radius or its flights", "[assess]") {
  // δ/R by Hertz, (5 m v²/(4K))^(2/5)/R, is 1.4 for a soft ball of 20 kPa.
  const auto jelly = test::simulate(ball(2e4, 0.45, 0.8), Family::penalty);
  CHECK(jelly.contacts[0].penetration_ratio > 0.1);
  CHECK_THAT(notes_of(jelly),
             Contains("warning: penetration at floor reached") && Contains("of the radius of curvature"));
  CHECK_THAT(notes_of(jelly), !Contains("clearance"));
  // A nylon ball dropped from 4 µm: v = 8.9 mm/s, flights of 2 v/g = 1.8 ms and Hertz's 2.94
  // δ/v = 1.3 ms of contact, 0.7 of them before its weight makes contacts longer, though its
  // penetration is a thousandth of its radius.
  auto low = ball(1e9, 0.45, 0.99);
  low.mechanism.bodies[0].position->y() = radius + 4e-6;
  low.run.duration = 0.03;
  const auto quivers = test::simulate(low, Family::penalty);
  CAPTURE(notes_of(quivers), quivers.contacts[0].penetration_ratio);
  CHECK(quivers.contacts[0].penetration_ratio < 1e-3);
  CHECK(quivers.contacts[0].impact_over_flight > 0.5);
  CHECK_THAT(notes_of(quivers), Contains("of the free flights before them"));
}

TEST_CASE("rounding adds no energy to a resting body", "[assess]") {
  // A block on its two corners, almost level: gains of 1e-25 J, and of 1e-10 J relative to 0.1 J,
  // were once reported.
  const auto scene = read_scene(test::scene_file("block_on_corners"));
  for (const auto scheme : {Scheme::moreau_jean, Scheme::event_driven})
    for (const double y : {0.05, 0.06})
      for (const double angle : {0.0, 1e-9, 1e-3}) {
        auto other = scene;
        other.nonsmooth.scheme = scheme;
        other.mechanism.bodies[0].position->y() = y;
        other.mechanism.bodies[0].angle = angle;
        CAPTURE(y, angle, static_cast<int>(scheme));
        const auto run = test::simulate(other, Family::nonsmooth);
        CHECK(run.ending.status == Ending::Status::finished);
        CHECK_THAT(notes_of(run), !Contains("increased the energy"));
        CHECK(run.extremes.gains == 0);
      }
  // Relative to the greatest kinetic energy so far: with 1e-3 J, 1e-9 is a gain and 1e-16 is not,
  // also at rest.
  Extremes e;
  e.count_gain(1e-9, 1e-3, 1e-12);
  e.count_gain(1e-16, 1e-3, 1e-12);
  e.count_gain(1e-27, 1e-30, 1e-12);
  CHECK(e.gains == 1);
  CHECK(e.greatest_gain == 1e-9);
}

TEST_CASE("notes with the prefix of earlier versions count as warnings", "[assess]") {
  CHECK(is_warning("warning: the contact is too soft"));
  CHECK(is_warning("DOUBTFUL: the contact is too soft"));
  CHECK_FALSE(is_warning("3 impacts increased the energy"));
}

TEST_CASE("contacts that add energy cause a note, and a warning where they drive the motion", "[assess]") {
  const auto outcome = [](double gain, double friction, double contact) {
    Result run;
    run.ledger.kinetic = 1;
    run.ledger.initial = 1;
    run.ledger.friction = friction;
    run.ledger.contact = contact;
    run.ledger.load = friction + contact;  // the balance closes
    if (gain > 0) run.extremes.gains = 3;
    run.extremes.greatest_gain = gain;
    warn(run, Family::nonsmooth, "nonsmooth.step");
    return notes_of(run);
  };
  CHECK(outcome(0, 0.2, -0.1).empty());  // one adds the energy that the other dissipates
  CHECK(outcome(0, -0.05, 0.03).empty());
  CHECK_THAT(outcome(0.05, 0, 0),
             Contains("3 impacts increased the energy, by up to 0.05 J: ") && !Contains("warning: "));
  CHECK_THAT(outcome(0.2, 0, 0), Contains("warning: 3 impacts increased the energy, by up to 0.2 J of 1 J"));
  CHECK_THAT(outcome(0.05, -0.2, 0), Contains("warning: 3 impacts"));
  CHECK_THAT(outcome(0, -0.2, 0.05),
             Contains("warning: contacts and their friction added 0.15 J to an energy "
                      "of 1 J"));
  // What friction takes again hides a gain in the balance: its terms are 100 J, of which 0.5 J are
  // little.
  Result run;
  run.ledger.kinetic = run.ledger.initial = 1;
  run.ledger.contact = -100;
  run.ledger.friction = 100;
  run.extremes.gains = 400;
  run.extremes.greatest_gain = 0.5;
  run.extremes.greatest_kinetic = 2;
  warn(run, Family::nonsmooth, "nonsmooth.step");
  CHECK_THAT(notes_of(run), Contains("warning: 400 impacts increased the energy, by up to 0.5 J of 2 J"));
}

TEST_CASE("penetrating surfaces are reported as overlapping, joints as open", "[assess][assembly]") {
  auto scene = ball(5e6, 0.45, 0.8);
  scene.mechanism.bodies[0].position->y() = radius - 3e-3;
  const System system(scene.mechanism);
  const auto open = worst_open_joint(system, {0, radius - 3e-3, 0});
  CHECK(open.overlap);
  CHECK(open.amount == Approx(3e-3));
  CHECK_THROWS_WITH(assemble(scene.mechanism, RunOptions::Start::given),
                    Contains("contacts.floor overlaps by 0.003 m") && !Contains("open"));
  auto pendulum = read_scene(test::scene_file("double_pendulum"));
  pendulum.mechanism.bodies[0].position->x() += 1e-3;
  CHECK_THROWS_WITH(assemble(pendulum.mechanism, RunOptions::Start::given),
                    Contains("stays open by 0.001 m") && !Contains("overlap") &&
                        Contains("correct the positions or use \"assembled\""));
}
