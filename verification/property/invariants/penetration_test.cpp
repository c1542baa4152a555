// Penetration of contacts stays small for every clearance and speed.
#include <catch2/catch.hpp>

#include "io/scene/read_scene.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;

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
