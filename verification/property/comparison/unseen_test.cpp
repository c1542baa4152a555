// Events between the instants at which an integrator evaluates the motion. The set of claims
// "missed-contacts" contains further cases.
#include "dynamics/system.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

Scene thrown(double off, double speed) {
  auto scene = parse_scene(
      test::body("ball", 0.2, 1e-5) + test::surface("s", 0.6, "young = 2e11\npoisson = 0.3\n") +
          test::discs("peg", "ground", "ball", 0.02, 0.03) + test::run_for(1, "start = \"given\"\n"),
      "throw");
  auto& ball = scene.mechanism.bodies[0];
  ball.position = {-0.5, off};
  ball.velocity = {speed, 0};
  scene.run.duration = 1 / speed;
  return scene;
}

bool reports_missed(const Result& run) { return test::notes_of(run).find("missed") != std::string::npos; }

}  // namespace

TEST_CASE("time stepping reports exactly when bodies may have passed through each other", "[unseen]") {
  auto scene = thrown(0.01, 100);
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  // 100 m/s in 1e-3 s is the width of 0.1 m itself; in 1e-5 s a hundredth of it.
  scene.nonsmooth.step = 1e-3;
  CHECK(reports_missed(test::simulate(scene, Family::nonsmooth)));
  scene.nonsmooth.step = 1e-5;
  const auto fine = test::simulate(scene, Family::nonsmooth);
  CHECK_FALSE(reports_missed(fine));
  CHECK(fine.events_seen == 1);
  // A journal in its bearing does not penetrate the wall after contact.
  CHECK_FALSE(reports_missed(test::simulate(read_scene(test::scene_file("gudgeon")), Family::nonsmooth)));
}

TEST_CASE("a table over an angle has a kink at each knot and a piece between two knots", "[unseen]") {
  const auto scene =
      parse_scene(test::body("rotor", 1, 0.5) + test::pin("pin", "ground", "rotor") +
                      test::drive("motor", "pin",
                                  "against = \"angle\"\ntorque_table = [[-1, 0], [0, 1], [1, 2], [2, 0]]\n") +
                      test::run_for(1),
                  "table");
  const System system(scene.mechanism);
  REQUIRE(system.phases() == 1);
  // The slope changes at −1 (from the return), 1 and 2, but not at 0.
  const double turn = 2 * M_PI;
  const auto is = [&](double angle, bool above, double low, double high) {
    const auto p = system.phase(0).piece(angle, above);
    CAPTURE(angle, above);
    CHECK(p.low == Approx(low).margin(1e-12));
    CHECK(p.high == Approx(high).margin(1e-12));
  };
  is(0, true, -1, 1);
  is(1, true, 1, 2);
  is(1, false, -1, 1);
  is(3, true, 2, turn - 1);
  is(-1, false, 2 - turn, -1);
  is(100 * turn + 1.5, true, 100 * turn + 1, 100 * turn + 2);
}

TEST_CASE("a contact of a spinning body with a peg is found at any spin", "[unseen]") {
  // A disc of 5 mm on an arm of 1 m touches a fixed one of 5 mm at the top of the circle when the
  // arm is close to vertical: |d| = 2 sin(φ/2) = 0.01, φ short of a right angle.
  for (const double spin : {1.0, 1e3, 1e5}) {
    auto scene =
        parse_scene(test::body("arm", 1, 0.5) + test::pin("pin", "ground", "arm") +
                        test::surface("s", 0.5, "young = 2e11\npoisson = 0.3\n") +
                        test::discs("peg", "ground", "arm", 0.005, 0.005, "s", "at = [[0, 1], [1, 0]]\n") +
                        test::run_for(1, "start = \"given\"\n"),
                    "spin");
    scene.mechanism.bodies[0].angular_velocity = spin;
    scene.run.duration = 3 / spin;
    const double exact = (M_PI / 2 - 2 * std::asin(0.005)) / spin;
    scene.nonsmooth.scheme = Scheme::event_driven;
    for (const auto family : {Family::penalty, Family::nonsmooth}) {
      const auto touches = test::touches(test::simulate(scene, family));
      CAPTURE(spin, name_of(family));
      REQUIRE_FALSE(touches.empty());
      CHECK(touches[0].t == Approx(exact).epsilon(1e-9));
    }
  }
}
