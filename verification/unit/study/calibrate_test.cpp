// Parts of the calibration, each against a closed form: correlated targets, open intervals,
// identifiability, measured files; and a fit by runs.
#include <boost/math/distributions/students_t.hpp>

#include "measure/alignment.hpp"
#include "study/calibration/calibrate.hpp"
#include "study/runs/case_run.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// Quadratics without noise: the surface is exact, and its error is zero.
ResponseSurface exact(int unknowns, const std::function<double(const Eigen::VectorXd&)>& y) {
  const auto points = space_filling(unknowns, 30);
  Eigen::VectorXd outcomes(30);
  for (int i = 0; i < 30; ++i) outcomes[i] = y(points.row(i).transpose());
  return {points, outcomes};
}

const std::vector<Unknown> one{{"a", "a", "", -1, 1, false}};

const std::string clearance = test::unknown("c", "joints.gudgeon.clearance", 0.2e-3, 1e-3);

}  // namespace

TEST_CASE("a ridge names the combination of unknowns that the targets determine", "[calibrate]") {
  // ln a and ln b in −1 … 1; the target ln a − 2 ln b = 0 ± 0.05 determines b²/a. Along the ridge a
  // passes its range and b ∝ √a; for a known a, ln b is known to 1.96·0.025.
  const std::vector<Unknown> two{{"a", "a", "", std::exp(-1.0), std::exp(1.0), true},
                                 {"b", "b", "", std::exp(-1.0), std::exp(1.0), true}};
  const auto both = exact(2, [](const Eigen::VectorXd& xi) { return xi[0] - 2 * xi[1]; });
  const Misfit misfit({{both, 0, 0.05, {}, 0, 0, 0}}, {{}});
  const auto found = ridge_of(misfit, fit(misfit, {true}, two), two);
  REQUIRE(found);
  CHECK(found->along == 0);
  CHECK(found->powers_of);
  CHECK(found->slope[1] == Approx(0.5).epsilon(1e-3));
  CHECK(found->follows[1]);
  CHECK(found->within[1] == Approx(std::expm1(1.96 * 0.025)).epsilon(1e-2));
  CHECK(found->ends[0][0] == Approx(std::exp(-1.0)).epsilon(1e-6));
  CHECK(found->ends[1][1] == Approx(std::exp(0.5)).epsilon(1e-3));
  // With another combination as a second target there is none.
  const auto other = exact(2, [](const Eigen::VectorXd& xi) { return xi[0] + xi[1]; });
  const Misfit apart({{both, 0, 0.05, {}, 0, 0, 0}, {other, 0, 0.05, {}, 1, 0, 1}}, {{}, {}});
  CHECK_FALSE(ridge_of(apart, fit(apart, {true, true}, two), two));
}

TEST_CASE("identifiability includes places that the targets cannot tell apart", "[calibrate]") {
  // y = ξ² ± 0.02: the linear interval at ξ is 1.96·0.02/(2|ξ|), but −ξ meets the target as well. Half the
  // distance between both is |ξ|, 0.5 in the median of the range.
  const auto bowl = exact(1, [](const Eigen::VectorXd& xi) { return xi[0] * xi[0]; });
  const auto seen = identifiability(Misfit({{bowl, 0, 0.02, {}, 0, 0, 0}}, {{}}), space_filling(1, 31));
  CHECK(seen.left_open[0] > 0.45);
  CHECK(seen.left_open[0] < 0.6);
}

TEST_CASE("correlated targets carry no more information than their correlation allows", "[calibrate]") {
  // Two statistics y = bξ of the same runs whose scatter has the same variance w and correlation ρ:
  // the information is
  // 2b²/(w (1 + ρ)), and the interval half t/√(that + pull). Treated as independent they give an
  // interval narrower by √(1 + ρ).
  const double b = 0.7;
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  Scatter scatter;
  for (int p = 0; p < 50; ++p) {
    Eigen::MatrixXd outcomes(4, 2);
    for (int s = 0; s < 4; ++s) {
      const double common = normal(engine);
      outcomes(s, 0) = 1 + 0.05 * (common + 0.3 * normal(engine));
      outcomes(s, 1) = 1 + 0.05 * (common + 0.3 * normal(engine));
    }
    scatter.add(Eigen::VectorXd::Zero(1), outcomes);
  }
  const auto local = scatter.at(Eigen::VectorXd::Zero(1));
  const auto surface = exact(1, [&](const Eigen::VectorXd& xi) { return b * xi[0]; });
  const Misfit misfit({{surface, 0, 1e-6, {}, 0, 0, 0}, {surface, 0, 1e-6, {}, 0, 1, 0}}, {scatter});
  const auto f = fit(misfit, {true, true}, one);
  const Eigen::Vector2d g(b, b);
  const double information = g.dot(local.covariance.inverse() * g) + Misfit::pull;
  const double t = boost::math::quantile(boost::math::students_t(local.freedom), 0.975);
  CHECK(local.freedom == Approx(150));
  CHECK(f.unknowns[0].high == Approx(t / std::sqrt(information)).epsilon(1e-3));
  CHECK(f.unknowns[0].low == Approx(-t / std::sqrt(information)).epsilon(1e-3));
  // As if they were independent measurements: two of variance w.
  const Misfit apart({{surface, 0, 1e-6, {}, 0, 0, 0}, {surface, 0, 1e-6, {}, 1, 1, 1}}, {scatter, scatter});
  CHECK(fit(apart, {true, true}, one).unknowns[0].high < 0.8 * f.unknowns[0].high);
  // A measurement that is the mean of four segments has half the uncertainty.
  const Misfit longer({{surface, 0, 1e-6, {4, 1}, 0, 0, 0}, {surface, 0, 1e-6, {4, 1}, 0, 1, 0}}, {scatter});
  CHECK(fit(longer, {true, true}, one).unknowns[0].high ==
        Approx(t / std::sqrt(4 * (information - Misfit::pull) + Misfit::pull)).epsilon(1e-3));
}

TEST_CASE("a confidence interval at a limit of its range is open there, and spans two minima",
          "[calibrate]") {
  // y = ξ measured as 0.9 ± 0.2: the lower end of the profile is 1.96·0.2 below 0.9, the upper one
  // is the end of the range.
  const auto line = exact(1, [](const Eigen::VectorXd& xi) { return xi[0]; });
  const double w = Misfit::pull, s = 0.2, best = 0.9 / (1 + w * s * s),
               half = 1.959964 / std::sqrt(1 / (s * s) + w);
  const auto f = fit(Misfit({{line, 0.9, s, {}, 0, 0, 0}}, {{}}), {true}, one);
  CHECK(f.unknowns[0].low == Approx(best - half).epsilon(1e-4));
  CHECK_FALSE(f.unknowns[0].open_low);
  CHECK(f.unknowns[0].high == 1);
  CHECK(f.unknowns[0].open_high);
  // y = ξ² measured as 0.49 ± 0.05: ξ = ±√(0.49 ± 0.098), both signs.
  const auto bowl = exact(1, [](const Eigen::VectorXd& xi) { return xi[0] * xi[0]; });
  const auto both = fit(Misfit({{bowl, 0.49, 0.05, {}, 0, 0, 0}}, {{}}), {true}, one);
  CHECK(both.unknowns[0].low == Approx(-std::sqrt(0.49 + 0.098)).epsilon(2e-3));
  CHECK(both.unknowns[0].high == Approx(std::sqrt(0.49 + 0.098)).epsilon(2e-3));
  CHECK_FALSE(both.unknowns[0].open_low);
}

TEST_CASE("identifiability: parameters without influence, and joint influence of targets", "[calibrate]") {
  const auto points = space_filling(2, 30);
  const std::vector<Scatter> none(2);
  // Both targets depend on ξ₁ alone.
  const auto first = exact(2, [](const Eigen::VectorXd& xi) { return xi[0]; });
  const auto blind =
      identifiability(Misfit({{first, 0, 0.1, {}, 0, 0, 0}, {first, 0, 0.1, {}, 1, 0, 1}}, none), points);
  CHECK(blind.identified(0));
  CHECK_FALSE(blind.identified(1));
  CHECK(blind.sensitivity(0, 0) == Approx(10).epsilon(1e-6));
  CHECK(blind.sensitivity(0, 1) == Approx(0).margin(1e-6));
  CHECK(blind.left_open[0] == Approx(1.96 / std::sqrt(2 * 100 + Misfit::pull)).epsilon(1e-6));
  // Both depend on the sum: each parameter is open, and their correlation is −1 except for the
  // pull.
  const auto sum = exact(2, [](const Eigen::VectorXd& xi) { return xi[0] + xi[1]; });
  const auto together =
      identifiability(Misfit({{sum, 0, 0.1, {}, 0, 0, 0}, {sum, 0, 0.1, {}, 1, 0, 1}}, none), points);
  CHECK_FALSE(together.identified(0));
  CHECK_FALSE(together.identified(1));
  CHECK(together.correlation(0, 1) < -0.99);
  // The sum and the difference: both are identified.
  const auto difference = exact(2, [](const Eigen::VectorXd& xi) { return xi[0] - xi[1]; });
  const auto seen =
      identifiability(Misfit({{sum, 0, 0.1, {}, 0, 0, 0}, {difference, 0, 0.1, {}, 1, 0, 1}}, none), points);
  CHECK(seen.identified(0));
  CHECK(seen.identified(1));
  CHECK(seen.correlation(0, 1) == Approx(0).margin(1e-6));
}

TEST_CASE("contradicting targets are rejected", "[calibrate]") {
  // y = ξ twice, measured as ±0.5 to 0.1: the middle differs by five standard deviations from each,
  // χ² = 50 for one degree of freedom.
  const auto line = exact(1, [](const Eigen::VectorXd& xi) { return xi[0]; });
  const std::vector<Scatter> none(2);
  const auto off =
      fit(Misfit({{line, 0.5, 0.1, {}, 0, 0, 0}, {line, -0.5, 0.1, {}, 1, 0, 1}}, none), {true, true}, one);
  CHECK(off.squares == Approx(50).epsilon(1e-3));
  CHECK(off.degrees == 1);
  CHECK(off.rejected);
  CHECK_FALSE(off.holds());
  const auto on =
      fit(Misfit({{line, 0.1, 0.1, {}, 0, 0, 0}, {line, -0.1, 0.1, {}, 1, 0, 1}}, none), {true, true}, one);
  CHECK_FALSE(on.rejected);
}

TEST_CASE("a long measured file is divided into segments of the length of a run", "[calibrate][study]") {
  // The peak of revolution k is 100 + k: of 12 revolutions in segments of 5 the greatest are 104
  // and 109, the expectation of runs of 5; the greatest of all, 111, is not.
  const test::StudyDesk desk;
  std::string csv = "t,acceleration,uncertainty\n";
  const double turn = 60.0 / 200;
  for (int i = 0; i < 12 * 600; ++i) {
    const int number = i / 600;
    csv += fmt::format("{},{},0.25\n", i * turn / 600,
                       i % 600 == 77 ? 100 + number : 20 * std::cos(2 * std::numbers::pi * i / 600));
  }
  desk.put("data.csv", csv);
  const auto study = [&](int revolutions) {
    return plan_calibration(
        desk.read(test::rig_study() +
                  fmt::format("[calibrate]\npoints = 5\nrevolutions = {}\n", revolutions) + clearance +
                  test::target("t", "peak_max", "data = \"data.csv\"\n")),
        {});
  };
  const auto five = study(5);
  CHECK(five.measured[0] == Approx(106.5));
  CHECK(five.targets[0].turns == 5);
  CHECK(five.targets[0].stretches.count == 2);
  CHECK(five.targets[0].noise == Approx(0.25));
  CHECK(five.study.variants[0].revolutions == 5);
  CHECK(five.study.variants[0].noise == Approx(0.25));
  // Runs longer than the file are shortened to it.
  const auto all = study(40);
  CHECK(all.measured[0] == Approx(111));
  CHECK(all.targets[0].stretches.count == 1);
  CHECK(all.study.variants[0].revolutions == 12);
}

TEST_CASE("a waveform is the difference of the mean revolutions of a run and of its file",
          "[calibrate][waveform][study]") {
  const test::StudyDesk desk;
  std::string csv = "crank_angle,acceleration,uncertainty\n";
  for (int i = 0; i < 4 * 600; ++i)
    csv += fmt::format("{},{},0.25\n", 0.6 * i,
                       20 * std::cos(2 * std::numbers::pi * i / 600) + (i / 600 % 2 == 0 ? 0.5 : -0.5));
  desk.put("data.csv", csv);
  const auto study = [&](const std::string& keys, const std::string& more = "") {
    return desk.read(test::rig_study() + more + "[calibrate]\npoints = 5\nrevolutions = 2\n" + clearance +
                     test::target("t", "waveform", keys));
  };
  const auto given = study("data = \"data.csv\"\ntolerance = 0.02\n");
  REQUIRE(given.measures.size() == 1);
  CHECK(given.measures[0].name == "waveform_t");
  const auto plan = plan_calibration(given, {});
  // The alternating part is an offset, which does not count: only t remains, in w and in its expectation.
  CHECK(plan.measured[0] == Approx(std::sqrt(2) * 0.02 * 20 / std::sqrt(2)).epsilon(1e-3));
  const auto run = run_case(given, Case{"", "nonsmooth", {}, 0, 2, given.scene, {}}, {});
  REQUIRE(run.measured.size() == 1);
  const auto mean = mean_of(run.metrics.turns);
  double squares = std::pow(0.02 * 20, 2) / 2;
  for (std::size_t k = 1; k < mean.size(); ++k) squares += 2 * std::norm(mean[k] - (k == 1 ? 10.0 : 0.0));
  CHECK(run.measured[0].value == Approx(std::sqrt(squares)).epsilon(1e-3));
  // A file of another crank speed says nothing about a run.
  const Case faster{"", "nonsmooth", {}, 0, 2, given.scene, {"drives.motor.speed_rpm=300"}};
  CHECK(std::isnan(run_case(given, faster, {}).measured[0].value));
  CHECK_THROWS_WITH(study("value = 3\n"), Contains("data") && Contains("is required for a waveform"));
  CHECK_THROWS_WITH(
      study("data = \"data.csv\"\n", "[measure.waveform_t]\ncolumn = \"t\"\nreduce = \"last\"\n"),
      Contains("measure waveform_t already has this name"));
}

TEST_CASE("a run compared with a noisy measurement contains its noise", "[calibrate][study]") {
  Study study;
  study.file = study.scene = test::source_folder() / "cases/flores2011-experiment/guide.toml";
  study.accelerometer = "accelerometer";
  study.joints = {"gudgeon"};
  study.length.discard = 1;
  Case one{"", "nonsmooth", {}, 0, 2, study.scene, {}};
  const auto rms = [&] { return run_case(study, one, {}).metrics.value[TurnMetrics::rms]; };
  const double quiet = rms();
  one.noise = 5;
  // 6,000 samples with a variance of 25: 25 ± 1.96·25√(2/6000) of the mean square, and as much of
  // the mixed term.
  const double noisy = rms();
  CHECK(noisy * noisy - quiet * quiet ==
        Approx(25).margin(1.96 * (25 * std::sqrt(2.0 / 6000) + 2 * 5 * quiet / std::sqrt(6000))));
  CHECK(rms() == noisy);
  one.start = 1;
  const auto other = identity(study, one, {}).digest();
  one.noise = 0;
  CHECK(identity(study, one, {}).digest() != other);
}

TEST_CASE("statistics that vary faster than the points of the design do not exclude the true value",
          "[calibrate][slow]") {
  // A slider-crank whose statistics wave over the clearance with a period of a tenth of its range:
  // 16 points do not resolve that. The targets are those of runs with 0.25 mm, with 1 %, 0.2 % and
  // 1 %. A surface that is believed between its points rejected the true value.
  const test::StudyDesk desk;
  desk.put("scene.toml",
           "gravity = [0, 0]\n" +
               test::body("crank", 0.5, 5e-4,
                          "points = { shaft = [0, 0], pin = [0.05, 0], mass_centre = [0.01, 0] }\n") +
               test::body("rod", 0.3, 1e-3,
                          "points = { crank = [0, 0], gudgeon = [0.2, 0], mass_centre = [0.08, 0] }\n") +
               test::body("slider", 0.4, 2e-4) + test::pin("shaft", "ground", "crank", {0, 0}, {-0.01, 0}) +
               test::pin("crankpin", "crank", "rod", {0.04, 0}, {-0.08, 0}) +
               test::pin("gudgeon", "rod", "slider", {0.12, 0}, {0, 0}, test::loose(0.25e-3, 0.01)) +
               test::guide("guide", "ground", "slider") +
               test::surface("s", 0.5, 0.12, "young = 207e9\npoisson = 0.3\n") +
               test::drive("motor", "shaft", "speed_rpm = 200\n") +
               "[run]\nrevolutions = 2\nstart = \"ideal\"\n[instruments.acc]\ntype = \"accelerometer\"\n"
               "body = \"slider\"\naxis = [1, 0]\nbandwidth = 2000\nsampling = 10000\n");
  const std::string head =
      "scene = \"scene.toml\"\njoint = \"gudgeon\"\naccelerometer = \"acc\"\n"
      "revolutions = 3\ndiscard = 1\nstarts = 2\n";
  const auto truth = desk.read(head);
  const auto made = run_case(truth, Case{"", "nonsmooth", {}, 0, 3, truth.scene, {}}, {}).metrics.value;
  const auto close = [](const std::string& name, double value, double tolerance) {
    return test::target(name, name, fmt::format("value = {}\ntolerance = {}\n", value, tolerance));
  };
  const auto study =
      desk.read(head + "[calibrate]\npoints = 16\nstarts = 2\nrevolutions = 3\nleave_out = false\n" +
                test::unknown("clearance", "joints.gudgeon.clearance", 0.15e-3, 0.4e-3, "scale = \"log\"\n") +
                close("peak_median", made[TurnMetrics::peak_median], 0.01) +
                close("rms", made[TurnMetrics::rms], 0.002) +
                close("line_greatest", made[TurnMetrics::line_greatest], 0.01));
  const auto fit =
      calibrate(plan_calibration(study, {}), Conduct{}, FolderLock(desk.folder.path(), "test"), 0, {}).all;
  REQUIRE(fit.settled);
  CHECK(fit.unknowns[0].low < 0.25e-3);
  CHECK(fit.unknowns[0].high > 0.25e-3);
  // A fifth of the range: the runs do resolve the wave.
  CHECK(fit.unknowns[0].high - fit.unknowns[0].low < 0.05e-3);
}
