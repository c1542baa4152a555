// Contact forces of the penalty formulation during lasting contact: impacts on a lasting contact,
// greatest penetration, a start under load.
#include "formulations/contact/contact_law.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/impact_tables.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// A lever that a torque of 1 N m presses on a stop. From 10 ms on pulses of `areas` (N m s) act on
/// it, each 1 µs long, 40 ms apart.
Scene lever(const std::vector<double>& areas, std::vector<std::string> sets) {
  std::string table = "[0.0, -1.0]";
  double t = 0.01;
  for (const double area : areas) {
    for (const auto& [at, torque] :
         {std::pair{t, -1.0}, {t + 1e-7, -1 - area / 1e-6}, {t + 1e-6, -1 - area / 1e-6}, {t + 1.1e-6, -1.0}})
      table += fmt::format(", [{}, {}]", at, torque);
    t += 0.04;
  }
  if (!areas.empty())
    sets.insert(sets.end(), {fmt::format("drives.hammer.torque_table=[{}]", table),
                             fmt::format("run.duration={}", t - 0.038)});
  return read_scene(test::scene_file("tests/lever_on_stop"), sets);
}

/// Greatest separation speed over the greatest approach speed at the stop (m/s), from `from` to
/// `to`.
struct Rebound {
  double onto = 0, off = 0;
  double before = NAN;  // the velocity at `from`
};
Rebound rebound(const Scene& scene, double from, double to) {
  Simulation simulation(scene, "penalty");
  Rebound r;
  test::Listener listener;
  listener.on_step = [&](const Step& step) {
    if (step.t1 <= from) r.before = 0.5 * step.v1[2];
    if (step.t0 < from || step.t1 > to) return;
    r.onto = std::max(r.onto, -0.5 * step.v1[2]);
    r.off = std::max(r.off, 0.5 * step.v1[2]);
  };
  REQUIRE(simulation.run({.observers = {&listener}}).ending.status == Ending::Status::finished);
  return r;
}

}  // namespace

TEST_CASE("an impact on a lasting contact has the coefficient of restitution of the surface",
          "[penalty][impact]") {
  const std::string integrator =
      GENERATE("dopri5", "adams_bashforth_moulton", "rosenbrock4", "bulirsch_stoer");
  const std::string floor = GENERATE("", "penalty.v0_floor=1e-3", "penalty.v0_floor=0.05");
  const std::string law = GENERATE("exact", "lankarani-nikravesh", "flores");
  CAPTURE(integrator, floor, law);
  std::vector<std::string> sets{"penalty.integrator=" + integrator, "penalty.contact=" + law};
  if (!floor.empty()) sets.push_back(floor);
  const auto scene = lever({0.1}, sets);
  const auto r = rebound(scene, 0.01, 0.012);
  CHECK(r.onto == Approx(0.5).epsilon(0.02));  // 0.1 N m s on 0.1 kg m², at 0.5 m
  // χ(1 + ê) = ln[(1 + χ)/(1 − χê)] holds for a free impact. Here 2 N act during the 1.9e-4 s of
  // the contact (2e-3 of the impact's momentum, returned in expansion) and the pulse itself takes
  // 6e-3 of that time.
  const double chi = damping_factor(scene.penalty.contact, 0.9);
  CHECK(r.off / r.onto == Approx(delivered_restitution(chi)).margin(0.01));
}

TEST_CASE("each of several impacts on a lasting contact has the restitution of its own speed",
          "[penalty][impact]") {
  // Only a pulse that finds the lever at rest is compared. 40 ms after the larger pulse (e = 0.9,
  // the torque returns the lever at 5 m/s²) the lever still bounces; after the weaker one it rests
  // again.
  for (const auto& areas : {std::vector{0.02, 0.002}, std::vector{0.002, 0.02}}) {
    const auto scene = lever(areas, {"penalty.integrator=dopri5"});
    for (std::size_t i = 0; i < areas.size(); ++i) {
      CAPTURE(areas, i);
      const double from = 0.01 + 0.04 * static_cast<double>(i);
      const auto r = rebound(scene, from, from + 1e-3);
      if (std::abs(r.before) > 1e-3) continue;  // it still bounces
      CHECK(r.off / r.onto == Approx(0.9).margin(0.03));
    }
  }
}

TEST_CASE(
    "a free impact follows the contact law alone, whatever the treatment of impacts on lasting contacts",
    "[penalty][impact]") {
  // Without a load w = v₀ is the greatest, so the delivered restitution is that of the closed form
  // to the tolerance.
  auto scene = lever({}, {"drives.hammer.torque_table=[[0.0, 0.0], [1.0, 0.0]]",
                          "bodies.lever.angular_velocity=-1.0", "run.start=given", "run.duration=1e-3"});
  const auto r = rebound(scene, 0, 1);
  CHECK(r.off / r.onto == Approx(0.9).epsilon(1e-7));
}

TEST_CASE("the greatest penetration is the extremum, not the deepest end of a step", "[penalty]") {
  const std::string integrator =
      GENERATE("dopri5", "adams_bashforth_moulton", "rosenbrock4", "bulirsch_stoer");
  CAPTURE(integrator);
  const auto scene = read_scene(test::scene_file("ball_on_plane"),
                                {"penalty.integrator=" + integrator, "penalty.contact=hertz",
                                 "bodies.ball.position=[0, 0.1001]", "bodies.ball.velocity=[0, -0.7]",
                                 "surfaces.steel.restitution=1", "run.duration=2e-3", "run.start=ideal"});
  const auto run = test::simulate(scene, Family::penalty);
  REQUIRE(run.contacts[0].impacts + run.events_seen > 0);
  // Hertz without loss: m v²/2 = (2/5) K δ^(5/2), K = (4/3) E* √R, E* = E/(2(1 − ν²)).
  const double K = 4.0 / 3 * 2.07e11 / (2 * (1 - 0.09)) * std::sqrt(0.1);
  const double depth = std::pow(5 * 0.49 / (4 * K), 0.4);
  // Half a sine in steps of a fifth: the error of the quintic through the ends is
  // (0.2π)⁶/46080 = 1.3e-6 of the depth.
  CHECK(run.contacts[0].penetration == Approx(depth).epsilon(1e-5));
}

TEST_CASE("a body may start at the penetration at which its soft contact carries its weight",
          "[penalty][start]") {
  // δ = (m g/K)^(2/3): 1.2 mm for a radius of 100 mm and 1 MPa, and 57 µm for 100 MPa.
  const auto young = GENERATE(1e6, 1e8, 2e11);
  const double K = 4.0 / 3 * young / (2 * (1 - 0.09)) * std::sqrt(0.1), depth = std::pow(9.81 / K, 2.0 / 3);
  const auto scene = [&](double deep) {
    return read_scene(test::scene_file("ball_on_plane"),
                      {"gravity=[0, -9.81]", fmt::format("surfaces.steel.young={}", young),
                       fmt::format("bodies.ball.position=[0, {}]", 0.1 - deep)});
  };
  CAPTURE(young, depth);
  const auto run = test::finished(scene(depth), Family::penalty);
  CHECK(0.1 - run.final_state.q[1] == Approx(depth).epsilon(1e-6).margin(1e-16 * 100));
  CHECK(run.contacts[0].penetration == Approx(depth).epsilon(1e-6));
  CHECK_THROWS_WITH(test::simulate(scene(0.011), Family::penalty),
                    Contains("contacts.floor overlaps by 0.011 m"));
}

TEST_CASE("a resting contact does not separate in a short last step", "[nonsmooth]") {
  // A loaded journal on its bearing has a gap of its path's curvature, h³, between two steps: less
  // than the displacement in a whole step, more than that in a last step of a hundredth.
  for (const double duration : {0.05, 0.0500001, 0.05000000001, 0.050009999}) {
    CAPTURE(duration);
    const auto scene =
        read_scene(test::scene_file("ring"), {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-5",
                                              "run.discard=0", fmt::format("run.duration={}", duration)});
    const auto run = test::finished(scene, Family::nonsmooth);
    REQUIRE_FALSE(run.events.empty());
    CHECK(run.events.back().kind == EventKind::contact);
  }
}

TEST_CASE("a note names the surface property that a contact force law cannot model", "[penalty]") {
  const auto scene =
      lever({}, {"surfaces.steel.tangential_restitution=0.4", "drives.hammer.torque_table=[[0, 0], [1, 0]]"});
  const auto run = test::simulate(scene, Family::penalty);
  CHECK_THAT(test::notes_of(run), Contains("stop: tangential_restitution = 0.4 applies to impact laws"));
}

TEST_CASE("stored contact energy is lost while damping holds the force at zero until separation",
          "[penalty][impact]") {
  // A soft ball at rest, with penetration δ, is pulled away by its weight. Faster than v₀/χ from
  // the first micrometre on, it separates without a force, and all of U = (2/5) K δ^(5/2) is
  // dissipated, except (m/2)(v₀/χ)² < 1e-14 J.
  const std::string integrator =
      GENERATE("dopri5", "adams_bashforth_moulton", "rosenbrock4", "bulirsch_stoer");
  CAPTURE(integrator);
  const auto scene =
      read_scene(test::scene_file("ball_on_plane"),
                 {"penalty.integrator=" + integrator, "penalty.v0_floor=1e-6", "gravity=[0, 9.81]",
                  "bodies.ball.mass=1e-3", "bodies.ball.position=[0, 0.0999]", "surfaces.steel.young=1e7",
                  "surfaces.steel.restitution=0.5", "run.duration=0.01"});
  const auto run = test::finished(scene, Family::penalty);
  const double K = hertz_stiffness(1e7, 0.3, 0.1);
  CHECK(run.ledger.contact == Approx(0.4 * K * std::pow(1e-4, 2.5)).epsilon(1e-8));
}

TEST_CASE("a torque on one body does not lower the floor of v0 for a contact of another body",
          "[penalty][impact]") {
  // Only the torque sets a speed scale here: 1000 N m on a wheel. It does not act on the ball
  // beside it, of 1e-9 kg m².
  const auto scene = read_scene(
      test::scene_file("ball_on_plane"),
      {"bodies.wheel.mass=1", "bodies.wheel.inertia=1", "bodies.ball.mass=1e-3", "bodies.ball.inertia=1e-9",
       "bodies.ball.position=[3, 0.5]", "bodies.ball.velocity=[0, -1]", "surfaces.steel.restitution=0.5",
       "joints.axle.type=revolute", "joints.axle.between=[\"ground\", \"wheel\"]", "drives.motor.joint=axle",
       "drives.motor.torque=1000", "run.duration=0.45"});
  const auto run = test::finished(scene, Family::penalty);
  REQUIRE_FALSE(run.events.empty());
  CHECK(run.events.front().v_n_minus == Approx(-1).epsilon(1e-9));
  CHECK(run.events.front().v_n_plus ==
        Approx(0.5).epsilon(1e-4));  // the exact law, whose χ is computed to 1e-12
}

// Penalty contacts in a mechanism: prediction of a free impact with the effective mass, contacts
// that begin at rest, grazing contacts, and a start inside the wall.

namespace {
/// A pendulum at rest on a pivot with clearance, its pin at the lowest point of the bearing,
/// displaced by `lift` upwards.
Scene hanging(double lift) {
  auto scene = read_scene(test::scene_file("pendulum"));
  auto& body = scene.mechanism.bodies[0];
  body.angle = -1.5707963267948966;
  // The pin is 0.15 m above the centre of mass; the bearing's centre is the origin, its clearance
  // 0.5 mm.
  body.position = Vec2(0, -0.15 - 0.5e-3 + lift);
  scene.run.start = RunOptions::Start::given;
  scene.run.duration = 0.05;
  scene.run.discard = 0;
  return scene;
}
}  // namespace

TEST_CASE("a contact that begins at rest settles, in both formulations", "[contact]") {
  auto scene = hanging(0);
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    CAPTURE(family == Family::penalty);
    const auto run = test::finished(scene, family);
    // The weight compresses the contact by (mg/K)^(2/3) = 1e-7 m; no displacement exceeds a few
    // times that.
    CHECK(run.contacts[0].penetration < 1e-6);
    CHECK(run.ledger.kinetic < 1e-6);
    CHECK(run.contacts[0].lasting_fraction > 0.95);
  }
}

TEST_CASE("a start inside the wall is a contact from the first instant", "[contact]") {
  // 2 µm inside: Hertz's energy 0.4 K δ^2.5 accelerates the journal upwards; its energy must not
  // exceed that.
  auto scene = hanging(-2e-6);
  const auto run = test::finished(scene, Family::penalty);
  const double K = hertz_stiffness(207e9, 0.3, 10e-3 * 9.5e-3 / 0.5e-3),
               stored = 0.4 * K * std::pow(2e-6, 2.5);
  CHECK(run.ledger.initial - 0.471 * 9.81 * (-0.15 - 0.5e-3 - 2e-6) == Approx(stored).epsilon(1e-6));
  CHECK(run.ledger.kinetic < stored);
  CHECK(std::abs(run.ledger.closure()) < 1e-6 * stored);
}

TEST_CASE("a journal that only grazes the wall is handled", "[contact]") {
  // Started upwards from the bottom so that it just reaches the top: v² = 2 g (2c), a little less,
  // exactly that, and a little more.
  for (double factor : {1 - 1e-9, 1.0, 1 + 1e-12, 1 + 1e-9, 1 + 1e-6}) {
    auto scene = hanging(1e-9);
    scene.mechanism.bodies[0].velocity = Vec2(0, std::sqrt(2 * 9.81 * (1e-3 - 1e-9) * factor));
    scene.mechanism.surfaces[0].friction.reset();
    CAPTURE(factor);
    const auto run = test::finished(scene, Family::penalty);
    CHECK(std::abs(run.ledger.closure()) < 1e-6 * run.ledger.scale());
  }
}
