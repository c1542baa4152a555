// The test rig with clearance in all joints, two of a few micrometres, where a bounce lasts a
// hundredth of a step.
#include <catch2/catch.hpp>

#include "study/runs/case_run.hpp"
#include "values/warning.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;

TEST_CASE("three joints with clearance, two of a few micrometres, finish without a doubtful result",
          "[automatic]") {
  Study study;
  study.scene = test::source_folder() / "cases/flores2011-experiment/scene.toml";
  study.joints = {"gudgeon"};
  study.accelerometer = "accelerometer";
  study.starts.seed = 2011;
  study.length.discard = 0;
  for (int start = 0; start < 3; ++start) {
    const Case one{
        "",
        "nonsmooth",
        {},
        start,
        2,
        study.scene,
        {"nonsmooth.scheme=automatic", "joints.gudgeon.clearance=1e-3", "drives.motor.speed_rpm=250",
         "joints.main.clearance=9e-6", "joints.main.bearing_radius=8.5e-3", "joints.main.surface=steel",
         "joints.big_end.clearance=5e-6", "joints.big_end.bearing_radius=5e-3",
         "joints.big_end.surface=steel"}};
    const auto r = run_case(study, one, Conduct{});
    CAPTURE(start, r.ending.reason);
    CHECK(r.ending.status == Ending::Status::finished);
    for (const auto& note : r.notes) {
      CAPTURE(note);
      CHECK_FALSE(is_warning(note));  // a bounce that is missed ends deep in the wall
    }
  }
}
