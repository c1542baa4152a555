// Runs that must stop with a reason or be reported as doubtful, and the penetration of contacts.
#include "io/scene/read_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

TEST_CASE("an explicit integrator does not advance forever at tiny steps in a stiff lasting contact",
          "[penalty]") {
  // The contact rests: v0 is the floor, and χ/v0 with a picometre a second makes the contact so
  // stiff that stability requires steps of nanoseconds. The implicit method takes some hundred
  // steps; it takes over after 2000 of an explicit one.
  for (const char* integrator : {"adams_bashforth_moulton", "dopri5", "bulirsch_stoer", "rosenbrock4"}) {
    const auto run = test::simulate(
        *open_scene(test::scene_file("resting_journal"),
                    {"penalty.v0_floor=1e-12", std::string("penalty.integrator=") + integrator}),
        Family::penalty);
    CAPTURE(integrator);
    CHECK(run.ending.status == Ending::Status::finished);
    CHECK(run.work.steps < 10000);
  }
}

TEST_CASE("a run beyond the permitted range of numbers is refused", "[run]") {
  CHECK_THROWS_WITH(open_scene(test::scene_file("ring"), {"bodies.journal.angular_velocity=1e200"}),
                    Contains("must be at most 1e+12 rad/s"));
}

TEST_CASE("time steps too long for the flights are reported", "[nonsmooth]") {
  // At 0.11 m/s the journal crosses 0.1 mm in 0.9 ms: 90 steps of 1e-5 s, one of 1e-3 s.
  const auto notes = [](const std::string& step) {
    const auto scene = read_scene(test::flores(), {"joints.gudgeon.clearance=0.1e-3", "run.revolutions=2",
                                                   "run.discard=0", "nonsmooth.step=" + step});
    return test::notes_of(test::simulate(scene, Family::nonsmooth));
  };
  CHECK_THAT(notes("1e-5"), !Contains("warning: "));
  CHECK_THAT(notes("1e-3"), Contains("warning: the free flight before one of the fastest impacts lasted"));
}

TEST_CASE("penetration stays below a thousandth of the clearance over the settings of the paper",
          "[invariant]") {
  // At h = 1e-5 s, including lasting contact (more than 90 % of the time). Two revolutions each;
  // over fifty the greatest ratio was 3.7e-7 (docs/theory/nonsmooth.md).
  for (const double clearance : {0.1e-3, 0.25e-3, 0.5e-3, 1e-3})
    for (const double rpm : {100.0, 150.0, 200.0, 250.0}) {
      const auto scene = open_scene(test::flores(), {"joints.gudgeon.clearance=" + std::to_string(clearance),
                                                     "drives.motor.speed_rpm=" + std::to_string(rpm),
                                                     "run.revolutions=2", "run.discard=0.5"});
      const auto run = test::simulate(*scene, Family::nonsmooth);
      CAPTURE(clearance, rpm);
      REQUIRE(run.ending.status == Ending::Status::finished);
      CHECK(run.contacts[0].penetration_ratio < 1e-3);
      CHECK(run.contacts[0].lasting_fraction > 0.5);
      // The energy of position corrections: no gravity or spring here, so only rounding of 100 J.
      CHECK(std::abs(run.ledger.stabilisation) < 1e-6);
    }
}
