// Studies: bit-identity, resumption, refusals, and a complete calibration.
#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "study/calibration/calibrate.hpp"
#include "study/runs/case_run.hpp"
#include "study/runs/perturb.hpp"
#include "study/store/results.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

TEST_CASE("results of a sweep do not depend on threads, and it resumes", "[study]") {
  const test::StudyDesk desk;
  const auto& folder = desk.folder;
  const auto study =
      desk.read(test::rig_study() +
                "[axes.clearance]\nkey = \"joints.gudgeon.clearance\"\nvalues = [0.25e-3, 1e-3]\n"
                "[axes.speed]\nkey = \"drives.motor.speed_rpm\"\nvalues = [100.0, 250.0]\n");
  REQUIRE(cases(study).size() == 16);
  const auto all = [&](const std::string& name, int threads) {
    const FolderLock lock(folder.path(), "test");
    Results results(folder.path() / name, study);
    const auto summary = sweep(study, plan(study, {}), Conduct{}, results, lock, threads, {});
    CHECK(summary.ran == 16);
    CHECK(summary.failed == 0);
    return results.runs();
  };
  const auto one = all("one.db", 1), two = all("two.db", 2);
  REQUIRE(one.size() == 16);
  REQUIRE(two.size() == 16);
  for (std::size_t i = 0; i < 16; ++i) {
    CHECK(one[i].key == two[i].key);
    CHECK(one[i].values == two[i].values);
    for (int m = 0; m < TurnMetrics::count; ++m) CHECK(test::same_number(one[i].metric[m], two[i].metric[m]));
  }
  // Starts differ, formulations have the same start.
  CHECK(one[0].metric[TurnMetrics::peak_max] != one[1].metric[TurnMetrics::peak_max]);

  // Half of the study is no longer requested, and removed: when it is requested again, only that
  // half is run.
  const FolderLock lock(folder.path(), "test");
  Results results(folder.path() / "one.db", study);
  const auto runs = plan(study, {});
  const std::vector<PlannedRun> half(runs.begin(), runs.begin() + 8);
  const auto fewer = sweep(study, half, Conduct{}, results, lock, 2, {});
  CHECK(fewer.found == 8);
  CHECK(fewer.kept == 8);
  CHECK(results.runs().size() == 8);
  CHECK(results.keys().size() == 16);
  results.prune();
  CHECK(results.keys().size() == 8);
  int reported = 0;
  const auto again =
      sweep(study, runs, Conduct{}, results, lock, 2, [&](const SweepProgress&) { ++reported; });
  CHECK(again.found == 8);
  CHECK(again.ran == 8);
  CHECK(reported == 8);
  CHECK(results.runs().size() == 16);
}

TEST_CASE("invalid studies are refused", "[study]") {
  const test::StudyDesk desk;
  const auto head = test::rig_study();
  const std::string unknown = "[calibrate]\n[calibrate.unknowns.a]\nkey = \"x\"\nlow = 1\n";
  for (const auto& [text, message] :
       {std::pair(std::string("scene = 3\n"), "study.toml:1:9: scene: must be a text"),
        {head + "staarts = 2\n", "staarts: is not a key of a study; did you mean starts?"},
        {head + "formulations = [\"magic\"]\n", "\"magic\" is unknown"},
        {head + "seed = 1.5\n", "seed: must be a whole number"},
        {head + "[axes.a]\nkey = \"x\"\nvalues = []\n", "must be a list of numbers"},
        {head + unknown + "high = 1\n", "high: must be greater than low"},
        {head + unknown + "high = 2\n[calibrate.targets.t]\nstatistic = \"peek\"\nvalue = 1\n",
         "\"peek\" is neither a statistic nor a measure of the study; known are peak_5"}})
    CHECK_THAT(desk.refusal(text), Contains(message));
  // A key that no scene has shows before anything runs.
  const auto o =
      desk.sweep(head + "[axes.a]\nkey = \"joints.gudgeon.clearanse\"\nvalues = [1e-3]\n", "--allow-outside");
  CHECK(o.status == 2);
  CHECK_THAT(o.err, Contains("did you mean clearance"));
}

TEST_CASE("known parameters are recovered from a synthetic measurement through the whole chain",
          "[study][long]") {
  // Peaks stay in one state for a hundred revolutions and more: as six independent segments, they
  // gave an interval without the true value (13.0 to 15.1 N for 12).
  const test::StudyDesk desk;
  const auto& folder = desk.folder;
  const double band = 700, friction = 12;
  // The measurement: another start (seed) of the same rig at two clearances, written as by a user.
  const auto head = test::rig_study() + "formulations = [\"nonsmooth\"]\n";
  const auto synthetic = desk.read(head + "seed = 99\n");
  for (const double clearance : {0.25e-3, 1e-3}) {
    Case one{"",
             "nonsmooth",
             {},
             0,
             100,
             synthetic.scene,
             {fmt::format("joints.gudgeon.clearance={}", clearance),
              fmt::format("instruments.accelerometer.bandwidth={}", band),
              fmt::format("loads.bearing.force={}", friction)}};
    const auto scene = scene_of(synthetic, one, Conduct{});
    Simulation simulation(scene, "nonsmooth", {.matched = true});
    test::Listener listener;
    std::string csv = "t,acceleration\n";
    listener.on_sample = [&](std::size_t i, double t, double value) {
      if (i == 0 && t > scene.run.discard) csv += fmt::format("{},{}\n", t, value);
    };
    REQUIRE(simulation.run({.observers = {&listener}}).ending.status == Ending::Status::finished);
    desk.put(clearance < 5e-4 ? "small.csv" : "large.csv", csv);
  }
  const auto target = [](const char* name, const char* clearance, const char* statistic, const char* data) {
    return fmt::format(
        "[calibrate.targets.{}]\nset = [\"joints.gudgeon.clearance={}\"]\nstatistic = \"{}\"\n"
        "data = \"{}\"\ntolerance = 0.03\n",
        name, clearance, statistic, data);
  };
  const auto study = desk.read(
      head +
      "[calibrate]\npoints = 24\nstarts = 3\nrevolutions = 16\n"
      "[calibrate.unknowns.band]\nkey = \"instruments.accelerometer.bandwidth\"\nlow = 300.0\nhigh = 1500.0\n"
      "scale = \"log\"\n"
      "[calibrate.unknowns.friction]\nkey = \"loads.bearing.force\"\nlow = 5.0\nhigh = 25.0\n" +
      target("a", "0.25e-3", "peak_median", "small.csv") + target("b", "1e-3", "peak_median", "large.csv") +
      target("c", "1e-3", "rms", "large.csv") + target("d", "0.25e-3", "rms", "small.csv"));
  const auto r = calibrate(plan_calibration(study, {}), Conduct{}, FolderLock(folder.path(), "test"), 0, {});
  REQUIRE(r.sweep.failed == 0);
  const double truth[] = {band, friction};
  double left = 0;  // of both ranges, in logarithms
  for (int j : {0, 1}) {
    const auto& u = r.all.unknowns[j];
    CAPTURE(j, u.value, u.low, u.high);
    left += std::log(u.high / u.low);
    CHECK(u.low <= truth[j]);
    CHECK(truth[j] <= u.high);
  }
  // The result is informative: the ranges are factors of 5. Three starts of sixteen chaotic
  // revolutions leave 0.43 to 0.98 of them, over six measurements of 20 revolutions known to a
  // tenth; these are of 100, known to 0.03.
  CHECK(left < 0.9 * 2 * std::log(5));
  REQUIRE(r.left_out.size() == 4);
  // The true value is within the region of the fit: its targets are within the predictions of the
  // fit.
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& p = r.all.predictive[i];
    CAPTURE(i, r.measured[i], p.value, p.low, p.high);
    CHECK(p.low <= r.measured[i]);
    CHECK(r.measured[i] <= p.high);
    CHECK(r.all.draws.cwiseAbs().maxCoeff() <= 1);
  }
}

TEST_CASE("a statistic that is zero within the ranges is refused as a target", "[study]") {
  const test::StudyDesk desk;
  const auto text = [](const std::string& statistic) {
    return test::rig_study() +
           "line_share = 1e6\n[calibrate]\npoints = 5\nstarts = 1\nrevolutions = 1\n[calibrate.unknowns.c]\n"
           "key = \"joints.gudgeon.clearance\"\nlow = 0.2e-3\nhigh = 1e-3\n[calibrate.targets.t]\n"
           "value = 3\nstatistic = \"" +
           statistic + "\"\n";
  };
  // No line reaches a million times the ideal: all five outcomes are 0. Formerly they were omitted
  // silently.
  const auto plan = plan_calibration(desk.read(text("lines")), {});
  CHECK_THROWS_WITH(calibrate(plan, Conduct{}, FolderLock(desk.folder.path(), "test"), 0, {}),
                    Contains("study.toml: calibrate.targets.t: at 5 of 5 points (first: "
                             "joints.gudgeon.clearance = ") &&
                        Contains("lines is not positive"));
  CHECK_THAT(desk.refusal(text("loss_angle")),
             Contains("statistic: \"loss_angle\" is an angle on the circle"));
}

TEST_CASE("a study's energy per revolution excludes the losses of dampers", "[study]") {
  // As stated in docs/reference/study.md: energy lost in contacts, films and friction. The
  // coupling's damper dissipates hundreds of times as much.
  const auto file = test::source_folder() / "cases/flores2011-experiment/flywheel.toml";
  Study study;
  study.file = study.scene = file;
  study.accelerometer = "accelerometer";
  study.joints = {"gudgeon"};
  study.length.discard = 1;
  const Case one{"", "nonsmooth", {}, 0, 1.9, file, {}};
  const auto run = run_case(study, one, {});
  const auto scene = scene_of(study, one, {});
  Simulation simulation(scene, "nonsmooth", {.matched = true});
  simulation.run({.until = scene.run.discard});
  const auto before = simulation.ledger();
  simulation.run({.until = scene.run.duration});
  const auto after = simulation.ledger();
  CHECK(after.damping - before.damping >
        10 * (after.contact + after.friction - before.contact - before.friction));
  CHECK(run.metrics.value[TurnMetrics::energy_per_turn] ==
        Approx((after.contact + after.friction - before.contact - before.friction) / 1.9));
}

TEST_CASE("a four-bar with a required branch starts at any crank angle", "[study]") {
  // The pose is open with the crank above the line of the fixed pins and crossed with it below: one
  // assembly over the whole revolution.
  const auto scene = read_scene(test::source_folder() / "src/cli/templates/four-bar.toml");
  REQUIRE(scene.mechanism.assembly.branch);
  for (int start = 0; start < 6; ++start) {
    CAPTURE(start);
    const auto moved = perturbed(scene, {}, 1, start, {});
    CHECK_NOTHROW(Simulation(moved, "nonsmooth"));
  }
}
