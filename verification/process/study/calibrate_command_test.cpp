// freeplay calibrate: fits of statistics and of quantities of one run, and fits that are refused an interval.
#include "verification/references/bouncing_ball.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

test::Outcome calibrated(const test::StudyDesk& desk, const std::string& text) {
  desk.put("study.toml", text);
  return desk.run("calibrate", "--allow-outside");
}

/// The restitution of a dropped ball from the times of its first impacts.
std::string ball_study(int times) {
  const reference::BouncingBall ball{0.5, 9.81, 0.62};
  auto text = fmt::format("scene = \"{}\"\n", test::scene_file("bouncing_ball").string()) +
              test::unknown("restitution", "surfaces.rubber.restitution", 0.3, 0.9);
  for (int k = 1; k <= times; ++k)
    text += test::target(fmt::format("event_{}_t", k), fmt::format("event.{}.t", k),
                         fmt::format("value = {}\ndeviation = 1e-6\nset = [\"run.duration=2.0\"]\n",
                                     reference::ball_impact(ball, k).t));
  return text;
}

}  // namespace

TEST_CASE("a fit that is rejected has no intervals; a measure of the study can be a target", "[calibrate]") {
  const test::StudyDesk desk;
  const auto study = test::rig_study() +
                     test::measure("first", "t", "first", "at = \"main.angle crosses 30 deg upwards\"\n") +
                     test::measure("peak", "accelerometer", "peak") +
                     "[calibrate]\npoints = 6\nstarts = 2\nrevolutions = 1\nrefinements = 1\n" +
                     test::unknown("c", "joints.gudgeon.clearance", 0.2e-3, 1e-3);
  const auto off = calibrated(desk, study + test::target("t", "rms", "value = 1000.0\ntolerance = 0.01\n"));
  CAPTURE(off.out, off.err);
  CHECK(off.status == 1);
  CHECK_THAT(off.out, Contains("no interval: the fit is rejected"));
  const auto json = test::read_json(desk.at("out/calibration.json"));
  CHECK(json["fitted_to_all"]["unknowns"]["c"]["low"].is_null());
  CHECK(json["fitted_to_all"]["holds"] == false);
  CHECK(json["identifiability"]["unknowns"]["c"].contains("range_left_open"));
  const auto measure = calibrated(desk, study + test::target("t", "peak", "value = 40.0\ntolerance = 0.5\n"));
  CAPTURE(measure.out, measure.err);
  CHECK(measure.status <= 1);
  CHECK_THAT(measure.out, Contains("Identifiability"));
  CHECK_THAT(calibrated(desk, study + test::target("t", "peak", "data = \"x.csv\"\n")).err,
             Contains("a measure of a run, which a file of a signal cannot provide"));
}

TEST_CASE("the command calibrates to times of impacts, or says what these leave open", "[calibrate]") {
  const test::StudyDesk desk;
  REQUIRE(calibrated(desk, ball_study(5)).status == 0);
  const auto fit = test::read_json(desk.at("out/calibration.json"))["fitted_to_all"];
  CHECK(fit["unknowns"]["restitution"]["value"].get<double>() == Approx(0.62));
  CHECK(fit["fitted"]["event_5_t"]["residual"].get<double>() == Approx(0).margin(1e-3));
  // The first impact does not depend on the restitution.
  const auto open = calibrated(desk, ball_study(1));
  CAPTURE(open.out, open.err);
  CHECK(open.status == 1);
  CHECK_THAT(open.err, Contains("Not determined") && Contains("restitution"));
  CHECK_THAT(open.out, !Contains("meets"));
}
