// Studies: bit-identity, resumption, refusals, and a complete calibration.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "facade/simulation.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/scene.hpp"
#include "study/calibration/calibrate.hpp"
#include "study/runs/case_run.hpp"
#include "study/runs/perturb.hpp"
#include "study/store/results.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/support/ball_study.hpp"
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

// freeplay calibrate: fits of statistics and of quantities of one run, and fits that are refused an interval.

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

// freeplay validate of a study with measured points: verdicts, files and refusals.

namespace {

/// The bouncing ball rises by e² times its drop of 0.5 m.
struct Points : test::BallStudy {
  Points()
      : BallStudy(
            "values = [0.5, 0.8]\n[measure.highest]\ncolumn = \"ball.y\"\nreduce = \"max\"\n[derived]\n"
            "rise = "
            "\"highest - 0.05\"",
            "claims = \"points\"\npoints = \"points.csv\"\nformulations = [\"nonsmooth\"]\n") {}
  test::Outcome validate(const std::string& points) const {
    write_file(folder.path() / "points.csv", points);
    return run({"validate", study.string(), "-o", out.string()});
  }
};

}  // namespace

TEST_CASE("a study is compared with measured points", "[studies]") {
  const Points study;
  const auto good =
      study.validate("quantity,e,value,uncertainty\nrise,0.5,0.1251,0.001\nrise,0.8,0.3195,0.001\n");
  CAPTURE(good.out, good.err);
  CHECK(good.status == 0);
  CHECK_THAT(good.out, Catch::Contains("agrees: rise: 0 of 2 points outside"));
  auto document = nlohmann::json::parse(test::file_text(study.out / "points.json"));
  const auto& one = document["agreement"][0];
  CHECK(one["verdict"] == "agrees");
  CHECK(one["rms"].get<double>() == Approx(std::sqrt((1e-8 + 25e-8) / 2)).epsilon(1e-3));
  CHECK(one["greatest"].get<double>() == Approx(0.0005).epsilon(1e-3));
  CHECK_THAT(test::file_text(study.out / "points.csv"),
             Catch::Contains("rise,given,nonsmooth,0.5,0.1251,0.001,0.12"));

  const auto off =
      study.validate("quantity,e,value,uncertainty\nrise,0.5,0.1269,0.001\nrise,0.8,0.3221,0.001\n");
  CHECK(off.status == 0);  // a result, as any other
  CHECK_THAT(off.out, Catch::Contains("differs: rise: 1 of 2 points outside"));
  const auto open = study.validate("quantity,e,value\nrise,0.5,0.13\n");
  CHECK_THAT(open.out, Catch::Contains("is undecided: rise: greatest error"));
}

TEST_CASE("wrong files of measured points are refused with their line", "[studies]") {
  const Points study;
  const std::pair<const char*, const char*> wrong[] = {
      {"", "has no header"},
      {"quantity,value\nrise,1\n", "line 1: the column e is missing"},
      {"quantity,e,value\n", "has no values"},
      {"quantity,e,value\nfall,0.5,1\n", "line 2: the study has no measure or derived column \"fall\""},
      {"quantity,e,value\nrise,0.6,1\n", "line 2: the study makes no run at these values"},
      {"quantity,e,value\n\nrise,0.5,x\n", "line 3: value must be a number"},
      {"quantity,e,value\nrise,0.5,inf\n", "line 2: value must be a number"},
      {"quantity,e,value,uncertainty\nrise,0,5,0.1,0.2\n", "line 2: has 5 fields, the header has 4"},
      {"quantity,e,value,uncertainty\nrise,0.5,0.1,-1\n", "line 2: uncertainty must be"}};
  for (const auto& [text, message] : wrong) {
    const auto o = study.validate(text);
    CAPTURE(text, o.out, o.err);
    CHECK(o.status == 2);
    CHECK_THAT(o.err, Catch::Contains(message));
    CHECK_FALSE(std::filesystem::exists(study.out / "points.json"));
  }
}

TEST_CASE("the table of a sweep is in the order of the values, whatever that of the study", "[study]") {
  const test::BallStudy balls("values = [0.6, 0.3, 0.5]", "formulations = [\"nonsmooth\"]\n");
  const auto sweep = balls.run({"sweep", balls.study.string(), "-o", balls.out.string()});
  REQUIRE(sweep.status == 0);
  const auto at = [&](const char* value) {
    return sweep.out.find(std::string("\n  ") + value + "  nonsmooth");
  };
  CHECK(at("0.3") < at("0.5"));
  CHECK(at("0.5") < at("0.6"));
  CHECK(at("0.6") != sweep.out.npos);
}
